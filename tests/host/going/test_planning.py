"""Planning: a newer request takes the place of a plan that is still being computed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gazechair.going import mission
from gazechair.going.lattice import Lattice
from gazechair.going.mission import ARRIVED, PLANNING
from gazechair.going.path import Abandoned, NoPath, Path
from gazechair.going.plan import NO_WAY, Planner
from gazechair.going.planning import Planned, Planning
from goingrig import TWO_ROOMS, GoingChair, Later, floor

WAY = Path(np.array([(0.0, 0.0), (1.0, 0.0)]), None)
START, GOAL = (1.5, 2.0, 0.0), (6.5, 2.0, math.pi / 2)


def test_a_plan_is_taken_once_it_is_ready() -> None:
    later = Later()
    planning = Planning(later.submit)
    assert not planning.busy
    planning.begin(lambda over: NoPath("over") if over() else WAY)
    assert planning.busy
    assert planning.take() is None
    later.run(0)
    assert planning.take() is WAY
    assert not planning.busy
    assert planning.take() is None


@pytest.mark.parametrize("newer", [True, False])
def test_one_that_nobody_waits_for_learns_so_and_is_never_taken(newer: bool) -> None:
    later = Later()
    planning = Planning(later.submit)
    known: list[Callable[[], bool]] = []

    def job(over: Callable[[], bool]) -> Planned:
        known.append(over)
        return NoPath(NO_WAY)

    planning.begin(job)
    later.run(0)
    assert not known[0]()
    planning.abandon()
    if newer:
        planning.begin(lambda over: NoPath("over") if over() else WAY)
    assert known[0]()
    assert planning.take() is None
    assert planning.busy is newer
    if newer:
        later.run(1)
        assert planning.take() is WAY


def test_what_the_planner_raises_is_raised_once() -> None:
    later = Later()
    planning = Planning(later.submit)
    planning.begin(lambda _: WAY)
    later.jobs[0][1].set_exception(ValueError("no costmap"))
    with pytest.raises(ValueError, match="no costmap"):
        planning.take()
    assert planning.take() is None


@pytest.mark.parametrize("asked", [0, 1, 5, 30])
def test_a_plan_that_nobody_waits_for_ends_soon(
    asked: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    planner, left, moves = Planner(floor(TWO_ROOMS)), [asked], [0]
    before = Lattice._before

    def counted(*of: object) -> object:
        moves[0] += left[0] < 0
        return before(*of)  # type: ignore[arg-type]

    def over() -> bool:
        left[0] -= 1
        return left[0] < 0

    monkeypatch.setattr(Lattice, "_before", counted)
    with pytest.raises(Abandoned):
        planner.plan(START, GOAL, (), False, over)
    assert left[0] == -1
    assert moves[0] == 0
    assert isinstance(planner.plan(START, GOAL), Path)


def test_another_goal_does_not_wait_for_a_plan_to_the_one_before() -> None:
    later, chair = Later(), GoingChair(floor(TWO_ROOMS), START)
    chair.mission.go(GOAL)
    chair.run(8.0)
    old = chair.mission.path
    chair.mission.submit = later.submit
    chair.mission.go((6.5, 1.0, 0.0))
    chair.step()
    chair.mission.go((6.5, 1.5, 0.0))
    chair.step()
    assert len(later.jobs) == 2
    later.run(1)
    chair.step()
    assert chair.mission.path is not old
    assert chair.mission.path_to_goal is not None
    assert chair.mission.path_to_goal.points_m[-1].tolist() == [6.5, 1.5]


def test_a_plan_from_where_the_chair_only_was_believed_to_be_is_not_taken() -> None:
    later, chair = Later(), GoingChair(floor(TWO_ROOMS), START)
    chair.mission.go(GOAL)
    chair.run(6.0)
    chair.mission.submit = later.submit
    chair.mission.go((6.5, 1.0, 0.0))
    chair.step()
    x, y, heading = chair.pose
    chair.chair.place(x - 0.5, y, math.degrees(heading))
    chair.step()
    later.run(0)
    chair.step()
    assert chair.mission.state == PLANNING
    later.run(1)
    chair.step()
    assert chair.mission.path is not None
    assert chair.mission.path.points_m[0][0] < x - 0.1


def test_where_it_stops_beside_a_table_it_plans_anew_before_it_turns() -> None:
    """The plan to the other goal began 0.5 m farther back, where there is room to turn."""
    table = ((3.8, 2.16, 4.55, 2.53),)
    later, chair = Later(), GoingChair(floor(table, (8.25, 4.05)), (5.95, 1.68, math.pi))
    chair.mission.go((2.45, 1.68, math.pi))
    while chair.pose[0] > 5.64:
        chair.step()
    chair.mission.submit = later.submit
    chair.mission.go((6.56, 2.57, 1.34))
    done = 0
    for k in range(1200):
        chair.step()
        if k % 30 == 29:
            for number in range(done, len(later.jobs)):
                later.run(number)
            done = len(later.jobs)
        if chair.mission.state == ARRIVED:
            break
    assert chair.mission.state == ARRIVED
    assert chair.least_m > 0.03


def test_a_better_path_for_which_it_must_stop_is_taken_once_it_leads_on(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It used to brake out of the bend of the first path found."""
    chair = GoingChair(floor((), (9.0, 4.0)), START)
    chair.mission.go(GOAL)
    chair.run(6.0)
    plan, costs_s = chair.mission.planner.plan, []

    def hard_at_first(*of: Any) -> Planned:
        found = plan(*of)
        assert isinstance(found, Path)
        costs_s.append(found.cost_s + 50.0 * (not costs_s))
        return replace(found, cost_s=costs_s[-1])

    chair.mission.planner.plan = hard_at_first  # type: ignore[method-assign]
    for name in ("rolled_into", "turns_rolling"):
        monkeypatch.setattr(mission, name, lambda *_: None)
    monkeypatch.setattr(chair.mission._follower, "leads_on", lambda *_: len(costs_s) != 2)
    chair.mission.go((8.0, 2.0, 0.0))
    for _ in range(20):
        assert chair.step().linear_permille > 0
    assert len(costs_s) == 2
    assert chair.mission.path is not None
    assert chair.mission.path.cost_s == costs_s[0]
    for _ in range(20):
        assert chair.step().linear_permille > 0
    assert chair.mission.path.cost_s == costs_s[2]
