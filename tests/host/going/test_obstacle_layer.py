"""Obstacle layer: plans ignore walkers, what has left is cleared, a possible person is costly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from gazechair.base.footprint import Footprint, Margins
from gazechair.going.costmap import Costmap
from gazechair.going.obstacle_layer import ObstacleLayer
from goingrig import TWO_ROOMS, Person, floor, scan_of

HERE = (1.5, 2.0, 0.0)


@pytest.fixture
def costmap() -> Costmap:
    return floor(TWO_ROOMS)


def look(around: ObstacleLayer, costmap: Costmap, at_s: float, persons: Sequence[Person]) -> None:
    points, origins = scan_of(costmap, HERE, persons)
    around.scan(points, origins, at_s, HERE)
    costmap.refresh(at_s)


def clear_m(costmap: Costmap, place: Person) -> float:
    return float(costmap.clearance_m(np.array([place[0]]), np.array([place[1]]), 0.0)[0])


def test_who_walks_is_in_no_plan_and_who_stands_is(costmap: Costmap) -> None:
    around, stands = ObstacleLayer(costmap, Footprint()), (2.6, 3.4)
    for k in range(20):
        walks = 3.2, 0.9 + 0.08 * k
        look(around, costmap, 0.1 * k, [walks, stands])
    assert around.walker_within(*walks, 0.3)
    assert clear_m(costmap, walks) > 0.1
    assert clear_m(costmap, stands) < 0.0


def test_what_stands_within_a_wide_margin_is_no_part_of_the_chair(costmap: Costmap) -> None:
    footprint = Footprint(margins=Margins(front_m=0.3))
    around, stands = ObstacleLayer(costmap, footprint), (2.5, 2.0)  # 0.2 m before its front
    for k in range(5):
        look(around, costmap, 0.1 * k, [stands])
    assert clear_m(costmap, stands) < 0.0


def test_who_stood_and_has_left_is_forgotten_at_once(costmap: Costmap) -> None:
    around, stood = ObstacleLayer(costmap, Footprint()), (3.0, 2.0)
    for k in range(20):
        look(around, costmap, 0.1 * k, [stood])
    assert clear_m(costmap, stood) < 0.0
    look(around, costmap, 2.0, [])
    assert clear_m(costmap, stood) > 0.3


def test_what_looks_like_a_person_is_dear_to_head_for_but_not_who_walks(costmap: Costmap) -> None:
    around, stands = ObstacleLayer(costmap, Footprint()), (2.6, 2.9)
    for k in range(20):
        look(around, costmap, 0.1 * k, [(3.2, 1.0 + 0.08 * k), stands])
    costmap.refresh(60.0)  # overlaid obstacles have expired
    assert not len(costmap.standing_m)
    around.suspect()
    assert len(costmap.standing_m)
    assert np.hypot(*(costmap.standing_m - stands).T).max() < 0.3
