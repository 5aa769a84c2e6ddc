"""Smoothing: it asks the costmap only where a path may be better, and hardly at all in a hurry."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.going.costmap import Costmap
from gazechair.going.plan import Path, Planner
from gazechair.going.smooth import Refused, Smoother
from goingrig import TWO_ROOMS, floor

CLUTTER = (*TWO_ROOMS, (2.2, 0.0, 2.8, 1.2), (5.2, 2.6, 5.8, 4.0), (2.4, 3.0, 2.6, 3.2))
START, GOAL = (1.2, 0.9, 2.5), (6.8, 3.2, -2.0)


class Counted(Costmap):
    """Counts how often its clearance is asked for."""

    asked = 0

    def clearance_m(self, *of):  # type: ignore[no-untyped-def]
        self.asked += 1
        return super().clearance_m(*of)


@pytest.fixture
def costmap() -> Counted:
    made = floor(CLUTTER)
    made.__class__ = Counted
    assert isinstance(made, Counted)
    return made


def test_a_path_is_priced_only_as_far_as_it_may_be_better(costmap: Counted) -> None:
    points = [(1.2, 0.9), (1.5, 1.8), (3.0, 1.9), (4.9, 2.1), (6.0, 1.6), (6.8, 3.2)]
    heading = START[2], GOAL[2]
    cost = Smoother(costmap, *heading, False, ())._cost(points)
    assert 20.0 < cost < 300.0
    assert Smoother(costmap, *heading, False, ())._cost(points, cost + 1e-6) == pytest.approx(cost)
    assert Smoother(costmap, *heading, False, ())._cost(points, cost - 1e-6) > cost - 1e-6
    asked = costmap.asked
    length_s = float(np.hypot(*np.diff(np.array(points), axis=0).T).sum()) / 0.25
    assert Smoother(costmap, *heading, False, ())._cost(points, length_s) == math.inf
    assert costmap.asked == asked


def test_in_a_hurry_a_path_takes_a_third_of_the_look_ups_and_is_clear(costmap: Counted) -> None:
    planner = Planner(costmap)
    found, asked = [], []
    for hurry in (True, False):
        before = costmap.asked
        found.append(planner.plan(START, GOAL, (), hurry))
        asked.append(costmap.asked - before)
    hurried, smooth = found
    assert isinstance(hurried, Path)
    assert isinstance(smooth, Path)
    assert 3 * asked[0] < asked[1]
    assert hurried.clearance_m > 0.0
    first, same = (path.points_m[1] - path.points_m[0] for path in found)
    turn = math.atan2(first[1], first[0]) - math.atan2(same[1], same[0])
    assert abs(math.remainder(turn, 2.0 * math.pi)) < math.radians(20.0)


def test_in_a_hurry_where_removing_vertices_is_not_enough_they_are_moved() -> None:
    narrow = ((3.95, 0.0, 4.05, 1.525), (3.95, 2.375, 4.05, 4.0))
    planner = Planner(floor(narrow))
    for turned in (0.0, 0.3, -0.4, 1.2):
        found = planner.plan((1.5, 2.0, turned), (6.5, 2.0, math.pi / 2), (), True)
        assert isinstance(found, Path)


def test_backing_off_saves_no_wait_before_what_may_be_a_person() -> None:
    points = [np.array(one) for one in ((4.0, 2.0), (3.6, 2.0), (5.0, 2.0))]

    def cost_s(*refused: Refused) -> float:
        smooth = Smoother(floor(), 0.0, None, True, refused)
        return smooth(points, fixed=2, fixed_end=1)[2]

    here = 4.0, 2.0, 0.0
    assert cost_s(Refused(*here, False, 12.0)) == pytest.approx(cost_s())
    assert cost_s(Refused(*here, False, 12.0, person=True)) == pytest.approx(cost_s() + 12.0)
