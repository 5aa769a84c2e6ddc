"""Follower: re-aims where it must not steer, and starts gently after a stop."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.going.follow import STOP, Follower, Stick
from gazechair.going.pace import PERIOD_S
from gazechair.going.plan import Path
from gazemeasure.obstacles.attack import KINDS, AttackedChair
from gazemeasure.turn.board import settings_with
from gazesim.chair import Chair
from goingrig import numbers

NARROW_M, JAMS_M, WIDE_M = 0.05, 0.02, 0.50
STRAIGHT = Path(np.array([(0.0, 0.0), (4.0, 0.0)]), None)


def following(ticks: int, room_m: float) -> Follower:
    """Driving along the x axis, at full speed for some time."""
    follower = Follower(numbers())
    follower.take(STRAIGHT, (0.0, 0.0, 0.0))
    stick = STOP
    for n in range(ticks):
        follower.moved(stick, None, 0.0)
        stick = follower.step((0.012 * n, 0.0, 0.0), math.inf, room_m)
    assert stick.linear_permille > 500
    return follower


@pytest.mark.parametrize(
    ("room_m", "straight_m", "across_m", "turned_deg", "aims"),
    [
        (NARROW_M, JAMS_M, 0.0, 0.5, False),
        (NARROW_M, JAMS_M, 0.0, 4.0, True),
        (NARROW_M, JAMS_M, 0.05, 0.0, True),
        (NARROW_M, NARROW_M, 0.0, 4.0, False),  # there is room straight ahead, too
        (NARROW_M, JAMS_M, 0.05, -3.0, False),  # returning to the leg
        (WIDE_M, WIDE_M, 0.0, 4.0, False),  # steered instead
    ],
)
def test_where_it_would_jam_it_stops_and_aims_again(
    room_m: float, straight_m: float, across_m: float, turned_deg: float, aims: bool
) -> None:
    follower = following(80, room_m)
    off = (1.0, across_m, math.radians(turned_deg))
    stick = follower.step(off, math.inf, room_m, straight_m)
    assert (stick.linear_permille == 0) is aims
    for _ in range(60):
        follower.moved(STOP, 0.0, 0.0)
        stick = follower.step(off, math.inf, room_m, straight_m)
        if stick.turn_permille and not stick.linear_permille:
            break
    assert follower.turns_on_spot is aims
    if aims:
        assert np.sign(stick.turn_permille) == -np.sign(across_m + math.radians(turned_deg))


def test_a_new_way_that_it_is_not_aimed_at_is_aimed_at_where_it_would_jam() -> None:
    off = (0.0, 0.0, math.radians(4.0))
    for straight_m, turns in ((NARROW_M, False), (JAMS_M, True)):
        follower = Follower(numbers())
        follower.take(STRAIGHT, off)
        for _ in range(3):
            follower.moved(STOP, 0.0, 0.0)
            follower.step(off, math.inf, NARROW_M, straight_m)
        assert follower.turns_on_spot is turns


def test_the_last_centimetres_of_a_leg_that_it_does_not_look_along_are_left_out() -> None:
    """It used to begin, and at once to end, the turn to that leg, for ever."""
    follower = Follower(numbers())
    goal_rad = math.pi / 2
    follower.take(Path(np.array([(0.0, 0.0), (0.04, 0.0)]), goal_rad), (0.0, 0.0, math.radians(70)))
    for _ in range(10):
        follower.moved(STOP, 0.0, 0.0)
        follower.step((0.0, 0.0, math.radians(70.0)), math.inf, NARROW_M)
    assert follower.turns_on_spot


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("turn_deg", [6.0, 12.0, 15.0])
def test_where_it_is_narrow_a_turn_waits_for_what_its_pulse_makes(
    kind: str, turn_deg: float
) -> None:
    full = {"profile": 2, "linear_permille": 1000, "turn_permille": 1000}
    chair = AttackedChair("3.1", kind, settings_with(full), True)
    chair.place(0.0, 0.0, 0.0)
    follower = Follower(numbers())
    heading = math.radians(turn_deg)
    path = Path(np.array([(0.0, 0.0), (4.0 * math.cos(heading), 4.0 * math.sin(heading))]), None)
    follower.take(path, (0.0, 0.0, 0.0))
    stick = STOP
    for _ in range(300):
        follower.moved(stick, chair.speed_m_s, chair.yaw_rate_deg_s)
        at = (0.0, 0.0, math.radians(chair.heading_deg))
        stick = follower.step(at, math.inf, NARROW_M)
        if stick.linear_permille:
            break
        for _ in range(5):
            chair.step(0.01, (0.0, stick.turn_permille / 1000.0))
    assert stick.linear_permille
    for _ in range(150):
        chair.step(0.01, (0.0, 0.0))
    assert chair.heading_deg == pytest.approx(turn_deg, abs=2.0)


def test_after_the_board_held_it_back_it_starts_gently() -> None:
    follower = following(80, WIDE_M)
    for _ in range(40):
        follower.moved(STOP, 0.0, 0.0)
        follower.step((1.0, 0.0, 0.0), math.inf, WIDE_M)
    follower.moved(Stick(), 0.0, 0.0)
    assert follower.step((1.0, 0.0, 0.0), math.inf, WIDE_M).linear_permille < 250


def test_backing_out_it_comes_to_rest_before_it_drives_ahead() -> None:
    follower = Follower(numbers())
    follower.take(Path(np.array([(0.0, 0.0), (-4.0, 0.0)]), None, backward=True), (0.0, 0.0, 0.0))
    stick, at_m = STOP, 0.0
    for _ in range(60):
        follower.moved(stick, None, 0.0)
        stick = follower.step((at_m, 0.0, 0.0), math.inf, WIDE_M)
        at_m -= 0.01
    assert stick.linear_permille < -300
    follower.take(STRAIGHT, (at_m, 0.0, 0.0))
    asked = []
    for _ in range(40):
        follower.moved(stick, None, 0.0)
        stick = follower.step((at_m, 0.0, 0.0), math.inf, WIDE_M)
        asked.append(stick.linear_permille)
    assert asked[:3] == [0, 0, 0]
    first = next(one for one in asked if one)
    assert 0 < first < 150  # as from rest


def test_where_the_board_lets_no_curve_through_it_goes_straight_on_for_a_while() -> None:
    follower = following(80, 0.15)
    off = (1.0, 0.05, 0.0)
    assert follower.step(off, math.inf, 0.15).turn_permille < 0
    follower.moved(STOP, 0.2, 0.0)
    follower.step(off, math.inf, 0.15)
    asked = []
    for _ in range(60):
        follower.moved(Stick(100, 0), 0.05, 0.0)
        asked.append(follower.step((1.0, 0.03, 0.0), math.inf, 0.15))
    assert not any(one.turn_permille for one in asked[:30])
    assert asked[-1].turn_permille < 0


def test_it_has_arrived_when_the_turn_runs_out_at_the_heading() -> None:
    follower = Follower(numbers())
    chair = Chair("3.1")
    chair.place(0.0, 0.0, 0.0)
    chair.step(0.01, (0.0, 0.0))
    follower.take(Path(np.array([(0.0, 0.0), (0.01, 0.0)]), math.pi / 2), (0.0, 0.0, 0.0))
    stick = STOP
    for _ in range(200):
        follower.moved(stick, chair.speed_m_s, chair.yaw_rate_deg_s)
        stick = follower.step((0.0, 0.0, math.radians(chair.heading_deg)), math.inf, WIDE_M)
        if follower.arrived:
            break
        for _ in range(5):
            chair.step(0.01, (stick.linear_permille / 1000.0, stick.turn_permille / 1000.0))
    assert follower.arrived
    assert stick == STOP
    assert chair.yaw_rate_deg_s > 0.5
    for _ in range(150):
        chair.step(0.01, (0.0, 0.0))
    assert chair.heading_deg == pytest.approx(90.0, abs=2.5)


def test_a_curve_tells_nothing_about_the_output_of_a_turn_on_the_spot() -> None:
    """It took a curve's small output for that of the turn, and requested it far too long."""
    follower = following(80, WIDE_M)
    for _ in range(10):
        follower.moved(Stick(600, 60), 0.2, 1.0)
    for _ in range(40):
        follower.moved(STOP, 0.0, 0.0)
    follower.take(Path(np.array([(1.0, 0.0), (1.01, 0.0)]), math.radians(4.0)), (1.0, 0.0, 0.0))
    asked = longest = 0
    for _ in range(40):
        stick = follower.step((1.0, 0.0, 0.0), math.inf, WIDE_M)
        asked = asked + 1 if stick.turn_permille > 0 else 0
        longest = max(longest, asked)
        follower.moved(STOP, 0.0, 0.0)
    assert 0 < longest * PERIOD_S < 0.8


def test_after_a_leg_that_ends_early_it_aims_at_the_next_vertex_from_where_it_is() -> None:
    follower = Follower(numbers())
    follower.take(Path(np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 0.35)]), None), (0.0, 0.0, 0.0))
    here = (1.8, 0.05, 0.0)
    stick = follower.step(here, math.inf, WIDE_M)
    assert stick.linear_permille
    begun = follower.end_leg_early(here)
    assert begun.points_m.tolist() == [[0.0, 0.0], [1.8, 0.05], [2.0, 0.35]]
    to_goal = math.atan2(0.30, 0.20)
    for _ in range(40):
        follower.moved(STOP, 0.0, 0.0)
        follower.step((1.8, 0.05, to_goal), math.inf, WIDE_M)
    assert not follower.turns_on_spot  # it heads for the goal, and not along the leg as planned
    assert follower.leg == 1


def test_the_goal_stays_where_it_is_when_the_last_leg_ends_early() -> None:
    follower = Follower(numbers())
    follower.take(STRAIGHT, (0.0, 0.0, 0.0))
    assert follower.end_leg_early((3.9, 0.02, 0.0)).points_m.tolist() == [[0.0, 0.0], [4.0, 0.0]]


@pytest.mark.parametrize(("x_m", "ends"), [(0.0, False), (0.05, False), (0.2, True)])
def test_a_leg_that_has_just_begun_is_not_ended_early(x_m: float, ends: bool) -> None:
    follower = Follower(numbers())
    follower.take(Path(np.array([(0.0, 0.0), (0.28, 0.0), (0.1, 0.3)]), None), (0.0, 0.0, 0.0))
    assert (follower.early_turn_rad((x_m, 0.0, 0.0)) is not None) is ends


@pytest.mark.parametrize("across_m", [0.03, -0.03])
def test_backward_it_steers_towards_its_leg(across_m: float) -> None:
    follower = Follower(numbers())
    chair = Chair("3.1")
    chair.place(0.0, across_m, 0.0)
    chair.step(0.01, (0.0, 0.0))
    path = Path(np.array([(0.0, 0.0), (-1.5, 0.0)]), None, backward=True)
    follower.take(path, (0.0, across_m, 0.0))
    stick, off_m = STOP, []
    for _ in range(400):
        follower.moved(stick, chair.speed_m_s, chair.yaw_rate_deg_s)
        pose = (chair.x_m, chair.y_m, math.radians(chair.heading_deg))
        stick = follower.step(pose, math.inf, WIDE_M)
        for _ in range(5):
            chair.step(0.01, (stick.linear_permille / 1000.0, stick.turn_permille / 1000.0))
        off_m.append(abs(chair.y_m))
    assert follower.arrived
    assert chair.x_m == pytest.approx(-1.5, abs=0.1)
    assert max(off_m) < 0.035
    assert off_m[-1] < 0.015


@pytest.mark.parametrize("pressed", [True, False])
def test_another_press_which_ends_the_output_is_no_refusal_of_a_curve(pressed: bool) -> None:
    follower = following(80, WIDE_M)
    off = (1.0, 0.1, 0.0)
    assert follower.step(off, math.inf, WIDE_M, WIDE_M).turn_permille < 0
    if pressed:
        follower.press()
    follower.moved(STOP, 0.3, 0.0)
    assert (follower.step(off, math.inf, WIDE_M, WIDE_M).turn_permille < 0) is pressed


def test_a_chair_that_is_getting_faster_than_a_stop_is_worth_counts_as_rolling() -> None:
    """Taken for standing, it requested a turn, grew faster by its dead time, and dropped it."""
    follower = Follower(numbers())
    follower.take(STRAIGHT, (0.0, 0.0, 0.0))
    for _ in range(10):
        follower.moved(Stick(600, 0), None, 0.0)
    assert follower.rolling((0.0, 0.0, 0.0)) is not None
    for _ in range(40):
        follower.moved(STOP, None, 0.0)
    assert follower.rolling((0.0, 0.0, 0.0)) is None
