"""Headings that are late, and older than the beams: no lidar is taken for turned by that."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.board.state import BoardState
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.odometry.doubts import DIFFERS, TURNED
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.headings import beyond, rate_rad_s
from gazechair.sensing.odometry.odometry import Odometry
from gazelink import codes
from homerig import NOISE_M, flat
from host.sensing.test_inbox import motion_of

LATE_S = 0.025  # of the simulated sensor, with its sample period and the way to the host
STATE_MS, HALF_MS, BEAMS = 20, 50, 360


def heading_deg(at_s: float) -> float:
    """Still, then to the right, then back to the left, at 24 degrees/s at most."""
    times = np.arange(0.0, max(at_s, 0.01), 0.01)
    rates = np.interp(times, (1.0, 1.2, 4.0, 4.2, 4.5, 6.0), (0.0, -24.0, -24.0, 0.0, 24.0, 24.0))
    return float(rates.sum() * 0.01)


def piece(end_s: float, second: bool, chance: np.random.Generator) -> Piece:
    times = end_s - HALF_MS / 1000.0 * (1.0 - (np.arange(BEAMS) + 0.5) / BEAMS)
    directions = 180.0 * (np.arange(BEAMS) + 0.5) / BEAMS - (180.0 if second else 0.0)
    looks = np.radians(directions + [heading_deg(at_s) for at_s in times])
    metres = flat().cast(2.0, 1.8, looks, 0.25) + chance.normal(0.0, NOISE_M, BEAMS)
    return Piece(directions, metres, times, (0.0, 0.0), 2 * BEAMS)


def said(at_s: float) -> Motion:
    """What an inbox gets of the board's state, whose heading is late."""
    shown = heading_deg(at_s - LATE_S) % 360.0
    return motion_of(BoardState(codes.ARMED, 0, 0, 0, 0, 0, shown, 0, 300, 0, 0, 0, at_s))


def followed(silent: tuple[int, int] = (0, 0)) -> list[Estimate]:
    """Estimates of that turn; no report between the `silent` ms, as while a board restarts."""
    odometry, chance = Odometry(), np.random.default_rng(3)
    found: list[Estimate] = []
    for ms in range(STATE_MS, 6000, 10):
        if ms % STATE_MS == 0 and not silent[0] <= ms < silent[1]:
            odometry.motion(said(ms / 1000.0))
        if ms % HALF_MS == 0:
            estimate = odometry.piece(piece(ms / 1000.0, ms % (2 * HALF_MS) == 0, chance))
            found += [] if estimate is None else [estimate]
    return found


def test_a_turn_to_one_side_and_back_turns_no_lidar() -> None:
    found = followed()
    assert not any(TURNED in one.doubts for one in found)
    off = [one.heading_deg - found[0].heading_deg - heading_deg(one.time_s) for one in found]
    assert max(map(abs, off)) < 0.3


@pytest.mark.parametrize("begin_ms", [1000, 1100, 3900, 4400])
@pytest.mark.parametrize("lasts_ms", [160, 260, 500])
def test_a_time_without_headings_turns_no_lidar(begin_ms: int, lasts_ms: int) -> None:
    found = followed((begin_ms, begin_ms + lasts_ms))
    assert not any(TURNED in one.doubts for one in found)
    assert {one.track for one in found} == {0}


@pytest.mark.parametrize("zero_deg", [3.0, -7.0, 25.0])
def test_a_sensor_that_began_at_another_zero_is_no_turn_and_turns_no_lidar(zero_deg: float) -> None:
    """A board restarts in 0.2 s, and with it the sensor."""
    odometry, chance = Odometry(), np.random.default_rng(5)
    found: list[Estimate] = []
    for ms in range(STATE_MS, 6000, 10):
        at_s = ms / 1000.0
        if ms % STATE_MS == 0 and not 1400 <= ms < 1500:
            known = heading_deg(at_s) + (zero_deg if ms >= 1600 else 0.0)
            odometry.motion(Motion(at_s, None if 1500 <= ms < 1600 else known % 360.0))
        if ms % HALF_MS == 0:
            estimate = odometry.piece(piece(at_s, ms % (2 * HALF_MS) == 0, chance))
            found += [] if estimate is None else [estimate]
    assert not any({TURNED, DIFFERS}.intersection(one.doubts) for one in found)
    assert {one.track for one in found} == {0}
    off = [one.heading_deg - found[0].heading_deg - heading_deg(one.time_s) for one in found]
    assert abs(off[-1]) < 1.0


@pytest.mark.parametrize("missing", [(0, 600), (1500, 2500)], ids=["first", "meanwhile"])
def test_a_heading_that_was_missing_is_no_turn_and_turns_no_lidar(
    missing: tuple[int, int],
) -> None:
    odometry, chance = Odometry(), np.random.default_rng(4)
    found: list[Estimate] = []
    for ms in range(STATE_MS, 3500, 10):
        if ms % STATE_MS == 0 and not missing[0] <= ms < missing[1]:
            at_s = ms / 1000.0
            odometry.motion(Motion(at_s, (heading_deg(at_s) + 140.0) % 360.0))
        if ms % HALF_MS == 0:
            estimate = odometry.piece(piece(ms / 1000.0, ms % (2 * HALF_MS) == 0, chance))
            found += [] if estimate is None else [estimate]
    assert not any({TURNED, DIFFERS}.intersection(one.doubts) for one in found)
    off = [one.heading_deg - found[0].heading_deg - heading_deg(one.time_s) for one in found]
    assert abs(off[-1]) < 1.0  # lidars alone follow a turn late


def test_beams_newer_than_the_newest_heading_are_taken_for_turned_on() -> None:
    times = np.arange(0.0, 0.2, 0.02)
    headings = math.radians(20.0) * times
    assert rate_rad_s(0.1, times, headings) == pytest.approx(math.radians(20.0))
    after = float(np.interp(times[-1] + 0.03, *beyond(times, headings)))
    assert after == pytest.approx(math.radians(20.0) * (times[-1] + 0.03))


def test_headings_that_came_together_are_not_turned_on() -> None:
    times, headings = np.full(4, 1.0), np.array((0.0, 0.1, 0.2, 0.3))
    assert rate_rad_s(1.0, times, headings) == 0.0
    assert float(np.interp(1.05, *beyond(times, headings))) == pytest.approx(0.3)
    assert not len(beyond(np.zeros(0), np.zeros(0))[0])
