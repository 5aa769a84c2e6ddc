"""Assist's ways: corridors as wide as the chair, and the free way that the driver points at."""

import math

import numpy as np
import pytest

from gazechair.assist.corridors import FARTHEST_M, Corridors
from gazechair.assist.ways import Ways
from gazechair.base.footprint import Footprint, Margins

ANY_TURN = (360.0, 360.0)


def wall(x1, y1, x2, y2):
    count = max(2, round(math.dist((x1, y1), (x2, y2)) / 0.01))
    return np.linspace((x1, y1), (x2, y2), count)


def door(width_m, ahead_m, aside_m=0.0):
    left, right = aside_m + width_m / 2, aside_m - width_m / 2
    return np.concatenate((wall(ahead_m, left, ahead_m, 3.0), wall(ahead_m, right, ahead_m, -3.0)))


def choose(points, pointed_deg=0.0, turns_deg=ANY_TURN):
    ways = Ways(Footprint(margins=Margins()))
    return ways.choose(points, math.radians(pointed_deg), None, turns_deg, False)


def test_a_corridor_ends_at_the_first_thing_within_its_width():
    corridors = Corridors(np.array([(2.0, 0.3), (1.0, 0.6)]), np.zeros(1), 1.5)
    free = corridors.free_m(np.array([0.0, 0.4, -0.4]), 0.4)
    assert free[0] == pytest.approx([2.0, 1.0, FARTHEST_M])


def test_a_corridor_is_turned_to_the_left_for_a_positive_direction():
    corridors = Corridors(np.array([(0.0, 1.0), (0.01, 1.0)]), np.array([0.0, math.pi / 2]), 1.0)
    free = corridors.free_m(np.zeros(1), 0.2)[:, 0]
    assert free == pytest.approx([FARTHEST_M, 1.0])


def test_straight_on_with_room_enough_needs_no_help():
    assert choose(door(1.2, 2.0)) is None
    assert choose(wall(-1.0, 0.5, 4.0, 0.5)) is None


def test_nothing_leads_through_a_wall_or_a_door_too_narrow():
    assert choose(wall(1.5, -3.0, 1.5, 3.0)) is None
    assert choose(door(0.70, 2.0, 0.2)) is None


@pytest.mark.parametrize("side", [1, -1])
def test_a_door_beside_the_way_is_found_on_its_side(side):
    way = choose(door(0.90, 2.2, side * 0.25))
    assert way is not None
    assert (way.first_rad + way.then_rad) * side > math.radians(3.0)
    assert abs(way.then_rad) < math.radians(20.0)
    assert way.straight_m < 1.6


def test_a_door_far_off_where_the_driver_points_is_not_meant():
    way = choose(door(0.90, 2.2, 0.25), pointed_deg=-60.0)
    assert way is None or way.then_rad < math.radians(-20.0)


def test_a_chair_that_may_not_turn_is_not_told_to():
    way = choose(door(0.90, 1.2, 0.25), turns_deg=(1.0, 1.0))
    assert way is None or abs(way.first_rad) <= math.radians(4.0)


@pytest.mark.parametrize("near_m", [2.0, 2.5])
def test_a_turn_along_a_wall_that_comes_nearer_is_not_put_off(near_m):
    slope = math.tan(math.radians(20.0))
    way = choose(wall(near_m - 4.0, -4.0 * slope, near_m + 3.0, 3.0 * slope))
    assert way is not None
    assert way.first_rad > math.radians(10.0)
    assert way.then_rad > math.radians(10.0)


def test_before_a_wall_that_ends_beside_the_way_it_leads_past_its_end():
    past = np.concatenate((wall(1.15, -3.0, 1.15, 0.0), wall(1.8, 0.0, 1.8, 3.0)))
    way = choose(np.concatenate((past, wall(-1.0, -0.5, 1.15, -0.5))))
    assert way is not None
    assert way.then_rad > math.radians(15.0)
