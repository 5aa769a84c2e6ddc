"""Assist's copy of the board's rule, compared with the board's own bound and decisions."""

import math
from itertools import pairwise

import numpy as np
import pytest

from gazeboard.core import limits
from gazeboard.core.speed import SpeedBound
from gazeboard.core.stopping import Stopping
from gazechair.assist import assist
from gazechair.assist import permits as permits_module
from gazechair.assist.permits import Permits
from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.standing import Approach
from gazelink import arcs, codes
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row
from gazelink.zone import CREEP, FULL
from gazemeasure.turn.board import settings_with
from gazesim.zone import zone_of

STEP_S = 0.016
FAR = [arcs.FAR] * arcs.SIZE
NEAR = [3] * arcs.SIZE


def permits(outputs=(), **clearance):
    """Permits after these outputs, each (seconds, linear, turn), and with that clearance."""
    made = Permits()
    made.zone = zone_of()
    now_s = 1.0
    for lasts_s, linear, turn in outputs:
        for _ in range(round(lasts_s / STEP_S)):
            now_s += STEP_S
            made.output(now_s, linear, turn)
    made.clearance = Clearance(0, codes.REAL, now_s, **{"arcs": FAR, **clearance})
    return made


def reported_deg():
    return float(zone_of().of(codes.DIR_LEFT).permits_at[CREEP])


@pytest.mark.parametrize("direction", [codes.DIR_FORWARD, codes.DIR_LEFT, codes.DIR_RIGHT])
def test_the_speed_it_reckons_is_the_boards(direction):
    board, stopping = SpeedBound(8), Stopping(settings_with({}), direction, False)
    unit = 1000.0 if direction == codes.DIR_FORWARD else 16.0
    ours = Permits()
    ours.zone = zone_of()
    side = {
        codes.DIR_FORWARD: ours._forward,
        codes.DIR_LEFT: ours._left,
        codes.DIR_RIGHT: ours._right,
    }[direction]
    sign = -1 if direction == codes.DIR_RIGHT else 1
    requested = [0] * 10 + [600] * 60 + [200] * 60 + [0] * 60 + [350] * 20 + [0] * 200
    off = []
    for k, permille in enumerate(requested):
        for _ in range(2):
            bound = board.update(stopping, permille) / unit
        turn = 0 if direction == codes.DIR_FORWARD else sign * permille
        ours.output(1.0 + STEP_S * k, permille if turn == 0 else 0, turn)
        off.append(side.bound - bound)
    full = stopping.full / unit
    assert max(off) < 0.06 * full
    assert min(off) > -0.03 * full


def test_it_knows_how_long_the_chair_may_still_roll():
    assert permits([(1.0, 600, 0), (0.9, 0, 0)]).rolls
    assert not permits([(1.0, 600, 0), (2.5, 0, 0)]).rolls


def test_a_small_turn_needs_as_much_room_as_the_board_lets_any_begin_with():
    q4 = {"right_q4_deg": 16000}
    assert not permits(left_q4_deg=int(16 * (reported_deg() - 1.0)), **q4).on_the_spot(95)
    assert permits(left_q4_deg=int(16 * (reported_deg() + 3.0)), **q4).on_the_spot(95)
    assert permits(left_q4_deg=0, **q4).on_the_spot(-95)


def test_a_side_that_was_shut_opens_after_a_while_of_more_room():
    made = permits(left_q4_deg=100)
    assert not made.may_turn(1)
    enough = int(16 * (reported_deg() + 5.0))
    results = []
    for k in range(10):
        made.clearance = Clearance(
            0, codes.REAL, 2.0 + 0.1 * k, left_q4_deg=enough, right_q4_deg=16000, arcs=FAR
        )
        results.append((made.may_turn(1), made.on_the_spot(95), made.both(600, 95)))
    assert results[:3] == [(False, False, False)] * 3
    assert results[4:] == [(True, True, True)] * 6
    assert made.may_turn(-1)


def test_a_turn_may_begin_once_the_chair_no_longer_rolls_where_both_are_not_permitted():
    wide = {"left_q4_deg": 16000, "right_q4_deg": 16000}
    assert not permits([(1.0, 600, 0), (0.9, 0, 0)], arcs=NEAR, **wide).both(0, 180)
    assert permits([(1.0, 600, 0), (2.5, 0, 0)], arcs=NEAR, **wide).both(0, 180)
    assert permits([(1.0, 600, 0), (0.9, 0, 0)], **wide).both(0, 180)


def test_the_side_to_which_it_may_turn():
    assert permits([(0.5, 0, 300)]).turns_to == 1
    assert permits([(0.5, 0, -300)]).turns_to == -1
    assert permits([(0.5, 0, 300), (2.0, 0, 0)]).turns_to == 0


def test_a_person_who_appears_ahead_finds_it_so_slow_that_the_board_goes_on():
    one = zone_of().of(codes.DIR_FORWARD)
    approach, made = Approach(one), permits()
    ways = np.arange(approach.blocked_within_m + 0.02, 2.5, 0.02)
    slow = [made.surprise_permille(float(way_m)) for way_m in ways]
    for way_m, permille in zip(ways, slow, strict=True):
        speed = float(one.speeds[FULL]) * permille / 1000.0
        stop_m = float(np.interp(speed, one.speeds, one.stops)) + 0.1 * speed
        assert stop_m < approach.reported_m(float(way_m)) + 0.02
    assert all(before <= after for before, after in pairwise(slow))
    assert slow[-1] == 1000
    assert made.surprise_permille(0.5) == 1000
    assert Permits().surprise_permille(1.0) == 1000
    assert math.isfinite(approach.blocked_within_m)


def test_the_bands_are_the_boards() -> None:
    assert permits_module._AGAIN_M == limits.BAND_MM / 1000.0
    assert permits_module._AGAIN_DEG == limits.BAND_Q4_DEG / 16.0


def test_a_turn_begins_above_the_deadband_of_every_chair_that_is_not_tuned() -> None:
    for profile in range(len(PROFILES)):
        deadband = TABLE[index_of(profile_row(profile, "deadband_permille"))][1]
        assert deadband <= assist._DEADBAND < 1.1 * deadband
