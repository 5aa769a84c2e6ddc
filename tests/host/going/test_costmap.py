"""Costmap: the footprint against the map, no-go areas, the unseen, and what is seen now."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.base.footprint import Footprint, inside
from gazechair.going.costmap import KEPT_S
from gazechair.going.distance_field import discs_of, distances
from goingrig import TWO_ROOMS, floor


def test_distances_are_those_of_a_search() -> None:
    chance = np.random.default_rng(1)
    occupied = chance.random((40, 50)) < 0.02
    found = distances(occupied, 0.025, 0.5)
    cells = np.argwhere(occupied)
    for i, j in chance.integers(0, 40, (60, 2)):
        nearest = 0.025 * np.hypot(*(cells - (i, j)).T).min()
        assert found[i, j] == pytest.approx(min(nearest, 0.5), abs=1e-5)


def test_discs_cover_the_footprint_but_for_a_centimetre_and_nothing_else() -> None:
    body = Footprint().body
    discs = discs_of(body)
    xs, ys = np.meshgrid(np.arange(-0.6, 0.8, 0.01), np.arange(-0.5, 0.5, 0.01))
    points = np.stack((xs.ravel(), ys.ravel()), axis=1)
    gaps = np.hypot(*(points[:, None] - discs[None, :, :2]).transpose(2, 0, 1)) - discs[:, 2]
    least = gaps.min(axis=1)
    assert (least[inside(body, points)] < 0.02).all()
    assert (least[~inside(body, points)] > -0.01).all()


def test_clearance_is_the_gap_beside_the_chair() -> None:
    costmap = floor()
    one = np.array([2.0]), np.array([0.6]), np.array([0.0])
    # The wall's cells end at 0.05; the chair is 0.375 wide on each side.
    assert costmap.clearance_m(*one)[0] == pytest.approx(0.6 - 0.375 - 0.0375, abs=0.03)
    assert costmap.clearance_m(np.array([2.0]), np.array([0.3]), np.array([0.0]))[0] < 0.0


def test_no_go_areas_and_the_unseen_are_no_floor() -> None:
    drawn = np.array(((5.0, 1.0), (6.0, 1.0), (6.0, 3.0), (5.0, 3.0)))
    costmap = floor(unseen=((1.0, 1.0, 2.0, 3.0),), no_go=(drawn,))
    for x in (1.5, 5.5):
        assert costmap.clearance_m(np.array([x]), np.array([2.0]), np.array([0.0]))[0] < 0.0
    assert costmap.clearance_m(np.array([3.5]), np.array([2.0]), np.array([0.0]))[0] > 0.5


def test_a_strip_thinner_than_a_cell_counts() -> None:
    strip = np.array(((4.0, 0.0), (4.005, 0.0), (4.005, 4.0), (4.0, 4.0)))
    costmap = floor(no_go=(strip,))
    assert costmap.clearance_m(np.array([4.0]), np.array([2.0]), np.array([0.0]))[0] < 0.0


def test_a_gap_between_beams_is_floor() -> None:
    costmap = floor(unseen=((3.5, 2.0, 3.575, 2.075),))
    assert costmap.clearance_m(np.array([3.5]), np.array([2.0]), np.array([0.0]))[0] > 0.5


def test_what_is_seen_counts_until_it_was_not_seen_for_a_while() -> None:
    costmap = floor()
    ahead = np.array(((4.0, 2.0), (4.0, 2.05)))
    assert len(costmap.see(ahead, 10.0, (3.0, 2.0))) == 2
    assert costmap.refresh(10.1)
    pose = np.array([3.5]), np.array([2.0]), np.array([0.0])
    assert costmap.clearance_m(*pose)[0] < 0.0
    assert not costmap.refresh(10.2)
    assert costmap.refresh(10.0 + KEPT_S + 0.1)
    assert costmap.clearance_m(*pose)[0] > 0.5


def test_the_walls_of_the_map_are_no_news() -> None:
    costmap = floor()
    assert not len(costmap.see(np.array(((3.0, 0.06),)), 1.0, (3.0, 1.0)))


def test_a_gap_between_beams_is_floor_where_nothing_stands_near() -> None:
    gap = (3.85, 1.85, 4.15, 2.15)  # in the door of 1 m: no beam has passed there
    at = np.array([4.0]), np.array([2.0])
    assert floor(TWO_ROOMS, unseen=(gap,)).clearance_m(*at, 0.0)[0] > 0.05
    wide = (3.7, 1.7, 4.3, 2.3)
    assert floor(TWO_ROOMS, unseen=(wide,)).clearance_m(*at, 0.0)[0] < 0.0
    beside = (3.9, 1.45, 4.1, 1.75)  # of the frame, perhaps
    lower = np.array([4.0]), np.array([1.9])
    assert floor(TWO_ROOMS, unseen=(beside,)).clearance_m(*lower, 0.0)[0] < 0.0
    assert floor(TWO_ROOMS).clearance_m(*lower, 0.0)[0] > 0.05
