"""Requests in vain: what the board refuses only while the chair may still roll is not given up."""

from __future__ import annotations

import math

import pytest

from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import ARRIVED, DRIVING, WAITING, at_once
from gazechair.going.pace import PERIOD_S
from gazechair.going.plan import Pose
from gazechair.going.recovery import OBSTACLE
from gazechair.going.stuck import Overruled
from goingrig import GoingChair, Later, floor

pytestmark = pytest.mark.costly

HALL = (10.0, 5.0)


@pytest.mark.parametrize("refused_s", [1.1, 1.5, 1.8])
def test_a_turn_is_requested_until_the_board_is_sure_that_the_chair_stands(
    refused_s: float,
) -> None:
    """Beside things it permits none before that: 1.8 s after the last output at most."""
    chair = GoingChair(floor((), HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(8.0)
    chair.mission.go((1.0, 2.0, math.pi))
    while chair.step().linear_permille:
        assert chair.now_s < 9.0
    begin_s, chair.refuses = chair.now_s, True
    while chair.now_s < begin_s + refused_s:
        chair.step()
    assert chair.mission._recovery.refused.all == ()
    chair.refuses = False
    assert chair.step() != STOP
    assert chair.run(90.0) == ARRIVED


def test_a_turn_that_is_refused_after_that_is_requested_for_moments_and_given_up() -> None:
    chair = GoingChair(floor((), HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(8.0)
    chair.mission.go((1.0, 2.0, math.pi))
    while chair.step().linear_permille:
        assert chair.now_s < 9.0
    chair.refuses, asked_s = True, 0.0
    for _ in range(round(4.0 / PERIOD_S)):
        chair.step()
        asked_s += PERIOD_S * (chair.asked != STOP)
    assert any(one.turns for one in chair.mission._recovery.refused.all)
    assert asked_s < 3.0


@pytest.mark.parametrize("goal", [(1.0, 2.0, math.pi), (8.5, 2.0, 0.0)], ids=["a turn", "a leg"])
def test_what_is_refused_is_requested_for_moments_while_a_plan_is_computed(goal: Pose) -> None:
    """Two plans of 6 s used up the 10 s of requests in vain after which the board ends a press."""
    chair = GoingChair(floor((), HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(8.0)
    chair.mission.go(goal)
    chair.run(1.5)
    later = Later()
    chair.mission.submit, chair.refuses = later.submit, True
    while not later.jobs:
        chair.step()
        assert chair.now_s < 14.0
    asked_s = 0.0
    for _ in range(round(6.0 / PERIOD_S)):
        chair.step()
        asked_s += PERIOD_S * (chair.asked != STOP)
    assert 0.0 < asked_s < 1.0
    chair.refuses = False
    assert any(chair.step() != STOP for _ in range(round(1.1 / PERIOD_S)))  # it may have gone
    chair.refuses = True
    chair.run(1.0)
    later.run(0)
    chair.step()
    assert all(chair.step() == STOP != chair.asked for _ in range(10))


@pytest.mark.parametrize("goal", [(1.0, 2.0, math.pi), (7.5, 2.0, 0.0)], ids=["a turn", "a leg"])
def test_what_is_refused_while_a_plan_is_computed_is_said(goal: Pose) -> None:
    """However long the plan takes: before, the chair stood and "drove" without a reason."""
    chair = GoingChair(floor((), HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(5.0)
    later = Later()
    chair.mission.submit, chair.refuses = later.submit, True
    chair.mission.go(goal)
    stood_s = 0.0
    while chair.mission.state != WAITING:
        chair.step()
        stood_s += PERIOD_S * (chair.chair.speed_m_s == 0.0)
        assert stood_s < 1.5
    for _ in range(round(6.0 / PERIOD_S)):
        chair.step()
        assert (chair.mission.state, chair.mission.reason) == (WAITING, OBSTACLE)
    chair.refuses = False
    chair.run(2.5)
    assert (chair.mission.state, chair.mission.reason) == (DRIVING, "")
    chair.mission.submit = at_once
    for number in range(len(later.jobs)):
        later.run(number)
    assert chair.run(90.0) == ARRIVED


def test_while_a_plan_is_computed_another_path_is_requested_at_once() -> None:
    overruled, go = Overruled(), Stick(500, 0)
    for _ in range(round(3.0 / PERIOD_S)):
        overruled.count(go, STOP)
    assert not overruled.asks_meanwhile(0.5)
    overruled.another_path()
    assert overruled.asks_meanwhile(0.5)
    for _ in range(round(0.7 / PERIOD_S)):
        overruled.count(go, STOP)
    assert not overruled.asks_meanwhile(0.5)
