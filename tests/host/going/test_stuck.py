"""A chair that stands says why; what the board stops is requested for moments only."""

from __future__ import annotations

import math

import pytest

from gazeboard.core.limits import AUTO_OVERRULED_MS
from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import ARRIVED, BLOCKED, LIMIT, WAITING
from gazechair.going.pace import PERIOD_S
from gazechair.going.recovery import STANDS
from gazechair.going.stuck import Overruled, Stuck
from goingrig import TWO_ROOMS, GoingChair, floor

pytestmark = pytest.mark.costly

GO = Stick(500, 0)
START, GOAL = (1.5, 2.0, 0.0), (6.5, 2.0, math.pi / 2)


def asked_in_vain_s(chair: GoingChair, seconds: float) -> float:
    """Counts like the board: the time that it refuses requests."""
    total = 0.0
    for _ in range(round(seconds / PERIOD_S)):
        chair.step()
        total += PERIOD_S * (chair.asked != STOP)
    return total


@pytest.mark.parametrize("goal", [(6.5, 2.0, math.pi / 2), (1.5, 2.0, math.pi)])
def test_a_minute_and_a_half_before_an_obstacle_do_not_end_the_press(
    goal: tuple[float, float, float],
) -> None:
    chair = GoingChair(floor(TWO_ROOMS), (1.5, 2.0, 0.0))
    chair.mission.go(goal)
    chair.run(2.0)
    chair.refuses = True
    in_vain_s = asked_in_vain_s(chair, 90.0)
    assert 1.0 < in_vain_s < AUTO_OVERRULED_MS / 1000.0 - 1.0
    chair.refuses = False
    assert chair.run(120.0) == ARRIVED


def test_it_asks_seldom_when_most_of_the_time_is_gone() -> None:
    overruled = Overruled()

    def share() -> float:
        return sum(overruled.asks(10.0 + PERIOD_S * n, PERIOD_S * n) for n in range(240)) / 240.0

    assert overruled.asks(0.0, 0.5)
    assert share() == pytest.approx(0.1, abs=0.03)
    for _ in range(round(6.5 / PERIOD_S)):
        overruled.count(GO, STOP)
    assert 0.0 < share() < 0.03
    overruled.count(GO, GO)
    assert share() == pytest.approx(0.1, abs=0.03)


def test_what_is_let_out_is_not_in_vain_until_the_chair_stands_for_long() -> None:
    stuck = Stuck((0.0, 0.0, 0.0))
    for n in range(40):
        stuck.count(True, GO, PERIOD_S * n)
    assert stuck.for_s(2.0) == 0.0
    for n in range(40, 100):
        stuck.count(True, GO, PERIOD_S * n)
    assert stuck.for_s(5.0) > 0.0


def test_a_chair_that_has_not_asked_is_not_stuck() -> None:
    stuck = Stuck((0.0, 0.0, 0.0))
    for n in range(100):
        stuck.count(False, STOP, PERIOD_S * n)
    assert stuck.for_s(5.0) == 0.0
    assert stuck.elsewhere((0.05, 0.0, 0.0))
    assert stuck.elsewhere((0.0, 0.0, 0.05))
    assert not stuck.elsewhere((0.02, 0.0, 0.02))


@pytest.mark.parametrize(("lets_out", "stuck_s"), [(False, 1.5), (True, None)])
def test_short_pulses_of_which_none_is_let_out_are_in_vain_soon(
    lets_out: bool, stuck_s: float | None
) -> None:
    stuck = Stuck((0.0, 0.0, 0.0), turns=True)
    found = None
    for n in range(60):
        pulse = n % 5 == 1  # the period after the request
        stuck.count(pulse, GO if pulse and lets_out else STOP, PERIOD_S * n)
        if found is None and stuck.for_s(PERIOD_S * n):
            found = PERIOD_S * n
    assert (found is None) if stuck_s is None else (found is not None and found < stuck_s)


@pytest.mark.parametrize("how", ["jammed", "no request"])
def test_a_chair_that_stands_though_nothing_is_in_the_way_says_so(
    how: str,
) -> None:
    chair = GoingChair(floor(TWO_ROOMS), START)
    chair.mission.go(GOAL)
    chair.run(4.0)
    if how == "jammed":
        chair.jammed = True
    else:
        chair.mission._follower.step = lambda *_: STOP  # type: ignore[method-assign]
    said, silent_s, silent_most_s = set(), 0.0, 0.0
    while chair.mission.state != BLOCKED:
        chair.step()
        said.add((chair.mission.state, chair.mission.reason))
        silent_s = 0.0 if chair.mission.reason else silent_s + PERIOD_S
        silent_most_s = max(silent_most_s, silent_s)
        assert chair.now_s < 30.0
    assert silent_most_s < 10.0
    assert {reason for _, reason in said} == {"", STANDS}
    assert chair.mission.reason == STANDS


def test_output_that_moves_no_chair_is_said_before_it_is_tried_again() -> None:
    """Three seconds of it; in the whole chair it was said after the second try, 7 s later."""
    chair = GoingChair(floor(TWO_ROOMS), START)
    chair.mission.go(GOAL)
    chair.run(4.0)
    chair.jammed, output_s = True, 0.0
    while chair.mission.state != WAITING:
        chair.step()
        stands = chair.chair.speed_m_s == 0.0
        output_s += PERIOD_S * (stands and chair.stick != STOP)
        assert output_s == 0.0 or chair.stick != STOP
    assert output_s < 3.0
    assert chair.mission.reason == STANDS


def test_a_speed_limit_too_low_to_turn_is_said_at_once_and_nothing_is_planned() -> None:
    chair = GoingChair(floor(TWO_ROOMS), START)
    chair.mission.cap_permille = 250
    chair.mission.go(GOAL)
    chair.run(20.0)
    assert (chair.mission.state, chair.mission.reason, chair.mission.plans) == (BLOCKED, LIMIT, 0)
    chair.mission.cap_permille = 300
    assert chair.run(90.0) == ARRIVED
    chair.mission.go(START)
    chair.run(3.0)
    chair.mission.cap_permille = 250
    chair.run(1.0)
    assert (chair.mission.state, chair.mission.reason) == (BLOCKED, LIMIT)
