"""Assist's advice: only with fresh scans, heading and clearance, and towards the free way."""

import math
from itertools import pairwise

import numpy as np
import pytest

from assistrig import RAYS, before_a_door, door_room, half
from gazechair.assist.assist import STRAIGHT_ON, Assist, _Leg, _Spot
from gazechair.assist.ways import Way
from gazechair.base.footprint import Footprint, Margins
from gazechair.board.board_commands import Clearance
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazelink import codes
from gazelink.arcs import ALL_FAR


@pytest.mark.parametrize("side", [1, -1])
def test_it_steers_towards_a_door_beside_the_way(side):
    advice = before_a_door(side * 0.25).advise(1, 1.1)
    assert advice.steers
    assert advice.turn_permille * side > 0
    assert 0 <= advice.linear_permille <= 1000


def test_straight_through_a_door_is_left_alone():
    assert before_a_door(0.0).advise(1, 1.1) == STRAIGHT_ON


def test_points_stay_where_they_are_while_the_chair_turns():
    assist = before_a_door(0.0)
    for k in range(5):
        assist.motion(Motion(1.1 + 0.01 * k, 10.0, 0, 0))
    points = assist._returns.points_m(1.15)
    post = points[np.argmin(np.hypot(points[:, 0] - 2.0, points[:, 1]))]
    turned = math.degrees(math.atan2(post[1], post[0]))
    assert abs(turned) > 1.0
    assert np.hypot(*points.T).min() == pytest.approx(2.05, abs=0.05)


@pytest.mark.parametrize("side", [1, -1])
def test_a_turn_that_the_board_did_not_let_begin_says_where_he_points(side):
    assist = before_a_door(0.0)
    q4 = {"left_q4_deg": 160, "right_q4_deg": 160}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=1200, **q4)
    assist.driver_turns(side, 1.05)
    assist.advise(1, 1.1)
    assert assist._press.pointed_deg == pytest.approx(side * 25.0, abs=1.0)
    free = before_a_door(0.0)
    free.driver_turns(side, 1.05)
    free.advise(1, 1.1)
    assert free._press.pointed_deg == 0.0


def test_before_what_may_be_a_person_it_asks_for_nothing_and_goes_on_when_it_may():
    assist = before_a_door(0.0)
    requested = []
    for k in range(45):
        now_s = 1.1 + 0.05 * k
        forward_mm = 1200 if k % 2 or k > 30 else 0  # seen at a shallow angle, it fluctuates
        assist.permits.clearance = Clearance(0, codes.REAL, now_s, forward_mm=forward_mm)
        assist.motion(Motion(now_s, 0.0, 0, 0))
        assist.see(0, half(door_room(-0.45, 0.45), now_s, 90.0 if k % 2 else -90.0))
        requested.append(assist.advise(1, now_s))
    assert all(one.linear_permille == one.turn_permille == 0 for one in requested[:35])
    assert all(one.waits for one in requested[:35])
    assert requested[-1] == STRAIGHT_ON
    assert not requested[-1].waits


@pytest.mark.parametrize(("forward_mm", "waits"), [(0, True), (200, False)])
def test_near_something_it_waits_if_a_possible_person_blocks_not_if_that_thing_is_too_near(
    forward_mm, waits
):
    assist = before_a_door(0.0, 1.0, 0.3)
    requested = []
    for k in range(30):  # longer than the board would be left to end the press
        now_s = 1.1 + 0.05 * k
        beside = {"left_q4_deg": 32, "right_q4_deg": 32}
        assist.permits.clearance = Clearance(0, codes.REAL, now_s, forward_mm=forward_mm, **beside)
        assist.motion(Motion(now_s, 0.0, 0, 0))
        assist.see(0, half(door_room(-0.15, 0.15, 1.0), now_s, -90.0 if k % 2 else 90.0))
        requested.append(assist.advise(1, now_s))
    assert 0.15 < assist._straight_m < 0.45
    assert all(one.waits == waits for one in requested)


def test_in_a_door_with_the_frame_beside_a_corner_it_goes_on_and_does_not_turn():
    assist = before_a_door(0.07, 1.2)
    beside = {"left_q4_deg": 4000, "right_q4_deg": 32}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=700, **beside)
    assert assist.advise(1, 1.1) == STRAIGHT_ON
    free = before_a_door(0.07, 1.2)
    assert free.advise(1, 1.1) != STRAIGHT_ON


@pytest.mark.parametrize("side", [1, -1])
def test_before_a_narrow_door_it_aims_at_the_middle_while_it_rolls(side):
    narrow = {"ahead_m": 1.2, "width_m": 0.81, "margins": Margins(0.05, 0.0, 0.05)}
    advice = before_a_door(side * 0.015, **narrow).advise(1, 1.1)
    assert advice.turn_permille * side > 0
    assert 0 < advice.linear_permille < 500
    assert before_a_door(0.0, **narrow).advise(1, 1.1).turn_permille == 0


def test_no_narrow_door_is_aimed_at_farther_from_where_the_driver_pointed():
    assist = before_a_door(0.015, 1.2, 0.81, Margins(0.05, 0.0, 0.05))
    assist.advise(1, 1.1)
    assist._press.pointed_deg = -60.0
    assert assist.advise(1, 1.11).turn_permille <= 0


@pytest.mark.parametrize("side", [1, -1])
def test_where_a_lidar_sits_in_front_the_side_needs_more_room(side):
    assist = Assist(Footprint(margins=Margins(0.05, 0.0, 0.05)), 2)
    front = Piece(np.zeros(0), np.zeros(0), np.zeros(0), (0.65, side * 0.376), RAYS)
    rear = Piece(np.zeros(0), np.zeros(0), np.zeros(0), (-0.45, -side * 0.4), RAYS)
    assist.see(0, front)
    assist.see(1, rear)
    left, right = assist._needs_m
    assert (left - right) * side == pytest.approx(0.013)


@pytest.mark.parametrize("side", [1, -1])
def test_waiting_it_asks_to_the_side_to_which_the_chair_turns(side):
    assist = before_a_door(0.0)
    for k in range(20):
        assist.motion(Motion(1.1 + 0.02 * k, 0.0, 0, side * 400))
    advice = assist._wait()
    assert advice.linear_permille == 0
    assert advice.turn_permille * side > 0


def test_a_turn_that_the_board_ended_counts_for_as_long_as_the_press_needs():
    assist = before_a_door(0.0)
    for k in range(20):
        now_s = 1.1 + 0.05 * k
        q4 = {"left_q4_deg": max(100, 480 - 30 * k)}
        assist.permits.clearance = Clearance(0, codes.REAL, now_s, forward_mm=1200, **q4)
        assist.motion(Motion(now_s, 1.0 * k, 0, 300))
        assist.driver_turns(1, now_s)
    for k in range(40):
        now_s = 2.1 + 0.1 * k
        assist.motion(Motion(now_s, 19.0, 0, 0))
        assist.see(0, half(door_room(-0.45, 0.45), now_s, 90.0 if k % 2 else -90.0))
        assist.advise(1, now_s)
    assert assist._press.pointed_deg - 19.0 > 17.0


@pytest.mark.parametrize(("arc", "drives"), [(0, False), (255, True)])
def test_after_a_turn_on_the_spot_it_waits_until_the_board_lets_it_drive(arc, drives):
    assist = before_a_door(0.0)
    arcs = (arc,) * len(ALL_FAR)
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=1200, arcs=arcs)
    assist.advise(1, 1.09)
    assist._press.leg = _Leg(assist._straight_m - 1.0, 0.0)
    for k in range(5):
        assist.motion(Motion(1.1 + 0.01 * k, 0.0, 0, 400))
    assert (assist.advise(1, 1.15).linear_permille > 0) == drives


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize(("off_deg", "goes_on"), [(1.2, True), (3.0, False)])
def test_a_turn_on_the_spot_that_rests_near_its_end_is_not_begun_anew(side, off_deg, goes_on):
    assist = before_a_door(0.0)
    free = {"left_q4_deg": 4000, "right_q4_deg": 4000}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=1200, **free)
    assist.advise(1, 1.09)
    assist._press.spot = _Spot(side * 8.0, 1.1)
    for k in range(60):  # the chair rolls past the leg's end
        deg = side * min(8.0 + off_deg, 0.4 * k)
        assist.motion(Motion(1.1 + 0.01 * k, deg, 0, 0))
        if k % 5 == 0 and assist._press.spot is not None:
            advice = assist._turn_on_the_spot(deg, 1.1 + 0.01 * k, 0.05)
    assert (advice is None) == goes_on


@pytest.mark.parametrize(("aim_deg", "turns"), [(1.5, False), (3.0, True)])
def test_where_a_curve_is_shut_it_stops_to_turn_only_by_what_a_chair_can_turn(aim_deg, turns):
    assist = before_a_door(0.0)
    free = {"left_q4_deg": 4000, "right_q4_deg": 4000, "arcs": (0,) * len(ALL_FAR)}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=1000, **free)
    assist.advise(1, 1.09)
    way = Way(math.radians(aim_deg), 0.5, 0.0, 1.0)
    assist._drive(way, 1.1, 0.05)
    assert (assist._press.spot is not None) == turns


@pytest.mark.parametrize(("ahead_m", "forward_mm", "swings"), [(0.85, 50, 2), (1.85, 1000, 11)])
def test_before_a_wall_it_turns_to_and_fro_only_a_few_times(ahead_m, forward_mm, swings):
    assist = before_a_door(0.0, ahead_m, 0.3)
    free = {"left_q4_deg": 4000, "right_q4_deg": 4000, "arcs": (0,) * len(ALL_FAR)}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=forward_mm, **free)
    turned = []
    for k in range(12):
        aim_rad = math.radians(10.0 * (-1) ** k)
        assist._ways.choose = lambda *_, aim_rad=aim_rad: Way(aim_rad, 0.0, aim_rad, 0.05)
        assist.advise(1, 1.09 + 0.001 * k)
        if assist._press.spot is not None:
            turned.append(assist._press.spot.to_deg)
        assist._press.spot = None
    assert sum(one != other for one, other in pairwise(turned)) == swings


@pytest.mark.parametrize(("forward_mm", "goes_on"), [(200, False), (400, True)])
def test_a_leg_ends_before_the_board_ends_the_press(forward_mm, goes_on):
    assist = before_a_door(0.0)
    free = {"left_q4_deg": 4000, "right_q4_deg": 4000}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.0, forward_mm=forward_mm, **free)
    assist.advise(1, 1.09)
    assist._person = False
    assist._press.leg = _Leg(assist._straight_m - 0.5, -30.0)
    advice = assist._on_leg(0.0, 1.1, 0.05)
    assert (advice.linear_permille > 0) == goes_on
    assert (advice.turn_permille < 0) != goes_on


@pytest.mark.parametrize(("forward_mm", "kept"), [(200, False), (1200, True)])
def test_before_what_may_be_a_person_the_way_that_led_there_is_not_preferred(forward_mm, kept):
    assist = before_a_door(0.25)
    assist.advise(1, 1.09)
    assert assist._press.way is not None
    requested = []
    assist._ways.choose = lambda points, pointed_rad, before, *more: requested.append(before)
    free = {"left_q4_deg": 4000, "right_q4_deg": 4000}
    assist.permits.clearance = Clearance(0, codes.REAL, 1.1, forward_mm=forward_mm, **free)
    assist._press.spot = None
    assist.advise(1, 1.1)
    assert [one is not None for one in requested] == [kept]


@pytest.mark.parametrize(("shut_s", "begins"), [(1.0, False), (0.5, True)])
def test_a_standing_chair_begins_no_curve_while_the_board_still_shuts_what_is_ahead(shut_s, begins):
    assist = before_a_door(0.035, 1.1, 0.81, Margins(0.05, 0.0, 0.05))
    for acquired_s, forward_mm in ((shut_s, 100), (1.05, 400)):
        assist.permits.clearance = Clearance(0, codes.REAL, acquired_s, forward_mm=forward_mm)
    assert (assist.advise(1, 1.1).linear_permille > 0) == begins


@pytest.mark.parametrize(("shut_s", "begins"), [(1.0, False), (0.5, True)])
def test_nor_a_curve_to_a_way_beside(shut_s, begins):
    assist = before_a_door(0.0)
    for acquired_s, forward_mm in ((shut_s, 100), (1.05, 400)):
        assist.permits.clearance = Clearance(0, codes.REAL, acquired_s, forward_mm=forward_mm)
    assist.advise(1, 1.1)
    assert (assist._curve(5.0) is not None) == begins


def turning(assist, deg_s, until_s):
    """Held for that long: what assist asks for, in steps of 0.05 s, from 1.1 s on."""
    assist.advise(1, 1.09)
    assist._press.spot = _Spot(70.0, 1.1)
    requested = []
    for k in range(round((until_s - 1.1) / 0.05)):
        now_s = 1.1 + 0.05 * k
        deg = deg_s * 0.05 * k
        assist.motion(Motion(now_s, deg, 0, 0))
        free = {"forward_mm": 1200, "left_q4_deg": 4000, "right_q4_deg": 4000}
        assist.permits.clearance = Clearance(0, codes.REAL, now_s, **free)
        assist.see(0, half(door_room(-0.45, 0.45), now_s, 90.0 if k % 2 else -90.0))
        requested.append(assist.advise(1, now_s))
    return requested


def test_a_turn_on_the_spot_of_a_chair_that_cannot_turn_is_given_up():
    assist = before_a_door(0.0)
    requested = turning(assist, 0.0, 9.0)
    assert requested[90].turn_permille == 600
    assert all(one == STRAIGHT_ON for one in requested[102:])
    assert assist._press.leg is None


def test_a_slow_one_is_not():
    assert turning(before_a_door(0.0), 4.0, 12.0)[-1].turn_permille > 0


def test_a_press_with_the_number_of_one_long_ago_does_not_point_where_that_one_did():
    assist = before_a_door(0.0)
    assist.advise(9, 1.1)
    for k in range(20):
        assist.motion(Motion(59.9 + 0.01 * k, 90.0, 0, 0))
    assist.see(0, half(door_room(-0.45, 0.45), 60.04, 90.0))
    assist.see(0, half(door_room(-0.45, 0.45), 60.09, -90.0))
    assist.advise(9, 60.1)
    assert assist._press.pointed_deg == 90.0
