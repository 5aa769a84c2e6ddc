"""Pieces of walls and open doors are not taken for persons; persons beside them are."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.base.footprint import Footprint
from gazechair.sensing.clearance.reach import LidarReach
from gazechair.sensing.clearance.standing import Approach
from gazechair.sensing.clearance.walls import askew, goes_on
from gazelink import codes
from gazesim.rooms import Person, Room, box
from gazesim.zone import zone_of
from lidarviews import HALL, NOISE_M, ORIGIN, points_of, view_of

pytestmark = pytest.mark.costly

ZONE = zone_of()
AHEAD = Approach(ZONE.of(codes.DIR_FORWARD))
CORNER = (0.66, 0.33)  # of the chair, where a lidar may sit
FRONT_M = 0.70  # of the outline and its margin


def forward_m(
    room: Room,
    chance: np.random.Generator,
    noise_m: float,
    heading_deg: float,
    origin_m: tuple[float, float] = ORIGIN,
) -> float:
    reach = LidarReach(Footprint())
    reach.use(ZONE)
    points = points_of(room, chance, noise_m, heading_deg=heading_deg, origin_m=origin_m)
    return reach.update(view_of(points, 0.0, origin_m))[codes.DIR_FORWARD]


def doorway(wall_m: float, left_m: float, right_m: float, *people: Person) -> Room:
    """A wall across, a doorway in it, and behind that its door, open."""
    walls = (
        box(left_m - 1.5, wall_m + 0.05, 3.0, 0.1, 0.0, 2.5, "wall"),
        box(right_m + 1.5, wall_m + 0.05, 3.0, 0.1, 0.0, 2.5, "wall"),
        box(left_m, wall_m + 0.55, 0.04, 1.0, 0.0, 2.0, "door"),
    )
    return Room("doorway", HALL, walls, people=people)


@pytest.mark.parametrize("heading_deg", [117.8, 118.3, 119.0])
def test_an_open_door_along_which_a_lidar_looks_is_nobody(heading_deg: float) -> None:
    # Between two steps from beam to beam, some pieces of it are as wide as a person.
    room = doorway(1.05, -0.72, 0.31)
    chance = np.random.default_rng(40)
    ways_m = [forward_m(room, chance, NOISE_M, heading_deg, CORNER) for _ in range(40)]
    assert min(ways_m) > 0.45


def test_a_corner_with_one_wall_seen_askew_is_nobody() -> None:
    room = Room("corner", HALL, (box(1.68, 0.98, 1.0, 1.5, 0.0, 2.0, "wall"),))
    chance = np.random.default_rng(3)
    assert min(forward_m(room, chance, NOISE_M, 15.0) for _ in range(60)) > 0.45


def test_somebody_in_an_open_door_or_before_a_wall_is_somebody() -> None:
    chance = np.random.default_rng(7)
    judged = 0
    while judged < 150:
        wall_m, left_m = chance.uniform(0.8, 2.0), chance.uniform(-1.5, 0.6)
        radius_m = float(chance.uniform(0.08, 0.25))
        x_m = left_m + chance.uniform(0.04 + radius_m, 0.9 - radius_m)
        y_m = wall_m + chance.uniform(-0.4, 0.9)
        far_m = math.hypot(x_m, y_m)
        gap_m = far_m - radius_m - FRONT_M
        if not 0.0 < gap_m < 1.2 or abs(math.atan2(x_m, y_m)) > 1.2:
            continue
        someone = Person(((x_m, y_m),), radius_m=radius_m)
        room = doorway(wall_m, left_m, left_m + 0.9, someone)
        heading_deg = math.degrees(math.atan2(y_m, x_m))
        way_m = forward_m(room, chance, float(chance.choice((NOISE_M, 0.02))), heading_deg)
        assert way_m <= AHEAD.reported_m(gap_m) + 0.06
        judged += 1


def test_a_piece_in_line_with_the_beams_beside_it_is_part_of_a_surface() -> None:
    door = np.column_stack((np.linspace(2.0, 1.2, 9), np.linspace(-0.2, 0.2, 9)))
    piece, before, after = door[3:6], door[2], door[6]
    assert askew(piece, before, after)
    assert askew(piece[::-1], after, before)
    assert not askew(piece, before, after + np.array((0.0, 0.05)))  # what is nearer is beside it
    assert not askew(piece, before + np.array((0.4, -0.2)), after)  # what is farther is far off
    assert not askew(piece, after, before)
    assert not askew(piece + np.array(((0.0, 0.0), (0.0, 0.1), (0.0, 0.0))), before, after)


def test_a_piece_that_another_lidar_sees_go_on_is_part_of_a_wall() -> None:
    wall = np.column_stack((np.full(60, 2.0), np.linspace(-1.0, 1.0, 60)))
    piece = wall[np.abs(wall[:, 1]) < 0.3]
    assert goes_on(piece, wall)
    assert not goes_on(piece, wall[wall[:, 1] < 0.3])  # no lidar sees it continue
    assert not goes_on(piece - (0.12, 0.0), wall)  # a person leans against it
    person = wall.copy()
    person[np.abs(wall[:, 1]) < 0.25, 0] -= 0.1
    assert not goes_on(piece, person)
