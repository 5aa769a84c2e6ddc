"""Beams: an obstacle that beams pass through is cleared, and thin things are kept."""

from __future__ import annotations

import numpy as np

from gazechair.going.beams import looked_through, of_each_lidar
from goingrig import LIDAR_M, TWO_ROOMS, floor, scan_of

PLACES = np.array(((2.0, 0.0), (1.9, 0.02), (2.0, 0.5), (-1.0, -1.2)))


def wall_at(x_m: float, origin: tuple[float, float] = (0.0, 0.0)) -> tuple[np.ndarray, np.ndarray]:
    """Beams to a wall across, half a degree apart."""
    slopes = np.tan(np.radians(np.arange(-40.0, 40.0, 0.5)))
    ends = np.stack((np.full(len(slopes), x_m), origin[1] + slopes * (x_m - origin[0])), axis=1)
    return ends, np.tile(origin, (len(ends), 1))


def test_what_a_lidar_looks_through_is_free_and_what_it_does_not_look_at_is_unknown() -> None:
    assert looked_through(PLACES, *wall_at(3.0)).tolist() == [True, True, True, False]


def test_a_thin_leg_and_what_is_just_before_a_wall_stay() -> None:
    ends, origins = wall_at(3.0)
    hit = np.abs(ends[:, 1] / ends[:, 0]) < 0.01
    ends[hit] *= 2.0 / 3.0  # a leg of 4 cm, at (2, 0)
    assert looked_through(PLACES, ends, origins).tolist() == [False, False, True, False]
    assert not looked_through(PLACES, *wall_at(2.04)).any()


def test_what_one_lidar_looks_through_is_free_though_another_does_not_see_it() -> None:
    near, far = wall_at(1.0), wall_at(3.0, (0.0, 0.6))
    both = np.concatenate((near[0], far[0])), np.concatenate((near[1], far[1]))
    assert looked_through(PLACES[:3], *both).all()


def test_the_pieces_of_a_turn_are_one_lidars() -> None:
    origins = np.repeat(((0.4, 0.3), (0.4, -0.3), (0.41, 0.3)), (3, 2, 4), axis=0)
    assert [one.tolist() for one in of_each_lidar(origins)] == [[0, 1, 2, 5, 6, 7, 8], [3, 4]]
    assert not of_each_lidar(np.zeros((0, 2)))


def test_who_has_left_is_forgotten_where_the_lidars_look_and_kept_out_of_sight() -> None:
    costmap = floor(TWO_ROOMS)
    pose, here = (1.5, 2.0, 0.0), (1.5 + LIDAR_M[0], 2.0)
    stood = np.array(((3.0, 2.0), (3.0, 2.05), (6.0, 0.3)))  # the last one behind the wall
    costmap.see(stood, 1.0, (3.0, 2.0))
    costmap.refresh(1.1)
    where = np.array((3.0, 6.0)), np.array((2.0, 0.6)), 0.0
    assert (costmap.clearance_m(*where) < 0.0).all()
    points, origins = scan_of(costmap, pose, [])
    costmap.clear(points + pose[:2], origins + pose[:2], 1.2)
    costmap.refresh(1.2)
    clear = costmap.clearance_m(*where)
    assert here == tuple(origins[0] + pose[:2])
    assert clear[0] > 0.3
    assert clear[1] < 0.0
