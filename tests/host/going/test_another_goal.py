"""Another goal on the way: what the chair does and reports until the path there is known."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future

import pytest

from gazechair.base.at_once import at_once
from gazechair.going.follow import STOP
from gazechair.going.mission import ARRIVED, DRIVING, PLANNING
from gazechair.going.planning import Planned
from goingrig import Box, GoingChair, floor

pytestmark = pytest.mark.costly

BESIDE_A_DOOR: tuple[Box, ...] = (
    (3.9, 0.0, 4.1, 2.4),
    (3.9, 3.5, 4.1, 6.0),
    (5.5, 2.0, 6.2, 4.0),
    (1.5, 4.5, 2.5, 6.0),
)
START, BEFORE, GOAL = (5.08, 1.49, 1.92), (1.74, 2.69, 0.12), (7.04, 1.87, -0.95)


def test_the_first_path_found_is_not_taken_where_the_board_refuses_its_first_turn() -> None:
    chair = GoingChair(floor(BESIDE_A_DOOR, (8.0, 6.0)), START)
    mission = chair.mission
    mission.go(BEFORE)
    chair.step()
    assert mission.state == DRIVING
    mission.go(GOAL)
    for _ in range(3):
        chair.step()
        path = mission.path_to_goal
        aim_rad = None if path is None else path.aim_rad(0, chair.pose)
        if aim_rad is not None and abs(math.remainder(aim_rad - chair.pose[2], math.tau)) > 0.1:
            assert mission.planner.turns_freely(chair.pose, aim_rad)
    assert mission.path_to_goal is not None
    assert chair.run(90.0) == ARRIVED


def test_where_the_path_before_ends_it_reports_that_it_plans_and_goes_on_once_it_has() -> None:
    chair = GoingChair(floor(), (2.0, 2.0, 0.0))
    mission = chair.mission
    mission.go((4.0, 2.0, 0.0))
    chair.run(3.0)
    assert mission.state == DRIVING
    late: list[Future[Planned]] = []
    jobs: list[Callable[[], Planned]] = []

    def later(job: Callable[[], Planned]) -> Future[Planned]:
        jobs.append(job)
        late.append(Future())
        return late[-1]

    mission.submit = later
    mission.go((6.0, 2.0, 0.0))
    for _ in range(300):
        chair.step()
    assert chair.stick == STOP
    assert mission.state == PLANNING
    mission.submit = at_once
    late[-1].set_result(jobs[-1]())
    assert chair.run(60.0) == ARRIVED
    assert math.dist(chair.pose[:2], (6.0, 2.0)) < 0.1
