"""Where the chair was when a picture was taken."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.producers.odometry_track import OdometryTrack
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate

RADIUS_M, RATE_DEG_S = 2.0, 20.0


def truth(at_s: float) -> np.ndarray:
    turned = math.radians(RATE_DEG_S) * at_s
    return np.array((RADIUS_M * math.sin(turned), RADIUS_M * (1 - math.cos(turned)), turned))


def estimate(at_s: float, track: int = 1, doubt: tuple[str, ...] = ()) -> Estimate:
    x, y, heading = truth(at_s)
    turned = math.remainder(math.degrees(heading), 360.0)
    speed = RADIUS_M * math.radians(RATE_DEG_S)
    return Estimate(at_s, x, y, turned, speed, 0.0, RATE_DEG_S, 0, 0, 0, 0, 1.0, doubt, track)


def moved(until_s: float) -> OdometryTrack:
    track = OdometryTrack()
    track.take(estimate(0.05 * k) for k in range(round(until_s / 0.05) + 1))
    return track


@pytest.mark.parametrize("at_s", [9.0, 9.37, 9.999, 10.0, 10.15])  # heading passes 180 degrees
def test_between_estimates_and_a_moment_beyond(at_s: float) -> None:
    pose = moved(10.0).pose(at_s)
    assert pose is not None
    off = pose - truth(at_s)
    assert math.hypot(*off[:2]) < 0.005
    assert abs(math.remainder(off[2], 2 * math.pi)) < math.radians(0.5)


def test_too_long_ago_or_to_come_is_not_known() -> None:
    track = moved(10.0)
    assert track.pose(4.9) is None
    assert track.pose(10.3) is None
    assert OdometryTrack().pose(0.0) is None


def test_old_doubted_or_begun_afresh() -> None:
    track = moved(10.0)
    assert track.known(10.2)
    assert not track.known(10.3)
    track.take([estimate(10.05, doubt=(doubts.LOST,))])
    assert not track.known(10.05)
    track.take([estimate(10.1, track=2)])
    assert track.known(10.1)
    assert track.pose(10.0) is None
