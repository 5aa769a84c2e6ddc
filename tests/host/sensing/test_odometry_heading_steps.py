"""A step of the heading sensor that the lidars have not seen is its fault and changes nothing."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.odometry import Odometry
from gazesim.homes import Home
from host.sensing.test_odometry_doubts import Path, first, pieces, room, still

STEP_AT_S = 2.0


def stepped(
    home: Home, path: Path, off_deg: Callable[[float], float], seconds: float
) -> list[Estimate]:
    """Estimates while the sensor is off by `off_deg` at each time."""
    odometry, chance, found = Odometry(), np.random.default_rng(2), []
    for piece in pieces(home, path, seconds):
        for time_s in np.arange(piece.times_s[0], piece.times_s[-1], 0.02):
            heading = path(float(time_s))[2] + off_deg(float(time_s)) + chance.normal(0.0, 0.1)
            odometry.motion(Motion(float(time_s), heading % 360.0, 0, 0))
        estimate = odometry.piece(piece)
        assert estimate is not None
        found.append(estimate)
    return found


def turns(time_s: float) -> tuple[float, float, float]:
    return 0.0, 0.0, 30.0 * max(0.0, time_s - 1.0)


def struck(time_s: float) -> tuple[float, float, float]:
    """Something hits it: 12 degrees within 60 ms."""
    return 0.0, 0.0, 12.0 * min(max(0.0, time_s - STEP_AT_S) / 0.06, 1.0)


@pytest.mark.parametrize("path", [still, turns])
@pytest.mark.parametrize("deg", [3.0, -7.0, 10.0, 40.0, -90.0])
def test_a_step_of_the_sensor_turns_neither_the_chair_nor_a_lidar(path: Path, deg: float) -> None:
    found = stepped(room(), path, lambda t: deg * (t >= STEP_AT_S), 4.0)
    off = [abs(one.heading_deg - path(one.time_s)[2] - found[0].heading_deg) for one in found]
    assert max(off) < 0.6
    assert STEP_AT_S < first(found, doubts.DIFFERS) < STEP_AT_S + 1.0
    assert first(found, doubts.TURNED) == math.inf
    assert {one.track for one in found} == {0}
    if path is still:
        assert first(found, doubts.PUSHED) == math.inf


def test_a_single_wrong_heading_moves_nothing() -> None:
    found = stepped(room(), still, lambda t: 25.0 * (0.0 <= t - STEP_AT_S < 0.02), 3.5)
    assert max(abs(one.heading_deg - found[0].heading_deg) for one in found) < 0.4
    assert first(found, doubts.PUSHED) == math.inf


def test_a_chair_that_is_struck_has_turned() -> None:
    found = stepped(room(), struck, lambda _t: 0.0, 4.0)
    later = [one for one in found if one.time_s > STEP_AT_S + 0.4]
    assert max(abs(one.heading_deg - found[0].heading_deg - 12.0) for one in later) < 0.5
    assert first(found, doubts.DIFFERS) == math.inf


def test_where_the_lidars_see_nothing_the_sensor_is_believed() -> None:
    found = stepped(room(40.0), still, lambda t: 10.0 * (t >= STEP_AT_S), 3.5)
    assert found[-1].heading_deg - found[0].heading_deg == pytest.approx(10.0, abs=0.5)
    assert first(found, doubts.PUSHED) == math.inf
