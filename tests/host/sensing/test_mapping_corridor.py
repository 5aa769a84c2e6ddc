"""Along a bare corridor the map tells no place: it is known by odometry, for as long as that is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.locating.map_match import Look, MapMatch
from gazechair.sensing.mapping.locating.open_directions import OpenDirections
from gazechair.sensing.mapping.locating.pose_information import PoseInformation
from gazesim.rooms import Room, Solid, box
from homerig import points, scan

HALF_M = 0.55
STEP_M = 0.1
CUPBOARDS = tuple(box(x, -0.45, 0.4, 0.2, 0.0, 1.8, "cupboard") for x in (-4.0, -0.5, 3.0, 6.0))
END = box(4.0, 0.0, 0.2, 2.0 * HALF_M, 0.0, 2.0, "wall")


def corridor(*more: Solid) -> Room:
    walls = tuple((-25.0, side, 25.0, side) for side in (-HALF_M, HALF_M))
    return Room("corridor", walls, more)


def look(room: Room, x_m: float, chance: np.random.Generator) -> Look:
    seen = points(*scan(room, np.array((x_m, 0.0, 0.0)), chance))
    return Look(seen, np.zeros_like(seen))


def grid_of(room: Room) -> OccupancyGrid:
    chance, keys = np.random.default_rng(5), []
    for x_m in np.arange(-8.0, 3.5, 0.5):
        seen = look(room, x_m, chance)
        keys.append(KeyScan(np.array((x_m, 0.0, 0.0)), seen.points_m, seen.origins_m, 0, 0, 0))
    return occupancy_of(keys)


def claims(room: Room, behind: float) -> list[float | None]:
    """How far a claimed place is off, m, as the chair drives on and odometry falls behind.

    `behind`: by that share of the way.
    """
    chance = np.random.default_rng(6)
    localization, found = Localization(grid_of(room)), []
    localization.place(np.array((-2.0, 0.0, 0.0)), np.zeros(3))
    for number in range(40):
        way_m = STEP_M * number
        x_m, odometry = way_m - 2.0, np.array(((1.0 - behind) * way_m, 0.0, 0.0))
        one = localization.look(look(room, x_m, chance), odometry, 0.3 * number, behind * way_m)
        found.append(None if one is None else math.hypot(*(one.pose[:2] - (x_m, 0.0))))
    return found


def test_in_a_bare_corridor_a_place_is_known_only_as_long_as_odometry_is_sure() -> None:
    found = claims(corridor(), 0.1)
    assert found[0] is not None
    assert found[-1] is None
    assert max(off_m for off_m in found if off_m is not None) < 0.1


def test_with_cupboards_along_it_a_corridor_is_as_good_as_a_room() -> None:
    found = claims(corridor(*CUPBOARDS), 0.03)
    assert None not in found
    assert max(off_m for off_m in found if off_m is not None) < 0.05


@pytest.mark.parametrize(
    ("more", "open_", "by_one"), [((), 1, 1), ((END,), 0, 1), (CUPBOARDS, 0, 0)]
)
def test_what_tells_the_place_along_a_corridor(
    more: tuple[Solid, ...], open_: int, by_one: int
) -> None:
    room, chance = corridor(*more), np.random.default_rng(7)
    seen = PoseInformation.of(
        MapMatch(grid_of(room)).ndt, look(room, 0.3, chance), np.array((0.3, 0.0, 0.0))
    )
    assert (len(seen.open_axes), len(seen.by_one)) == (open_, by_one)
    assert all(abs(axis[0]) > 0.999 for axis in (*seen.open_axes, *seen.by_one))


def test_one_thing_counts_where_odometry_agrees() -> None:
    room, chance = corridor(END), np.random.default_rng(7)
    seen = PoseInformation.of(
        MapMatch(grid_of(room)).ndt, look(room, 0.3, chance), np.array((0.3, 0.0, 0.0))
    )
    assert len(OpenDirections().axes(seen, np.array((0.01, 0.0)))) == 0
    assert len(OpenDirections().axes(seen, np.array((0.0, 0.3)))) == 0
    assert len(OpenDirections().axes(seen, np.array((-0.05, 0.0)))) == 1


@pytest.mark.parametrize("seed", range(4))
def test_rough_cells_of_a_bare_wall_tell_nothing_along_it(seed: int) -> None:
    """The wall is on a cell's edge, and the map's scans are a little off, as those of a drive."""
    room, chance = corridor(), np.random.default_rng(seed)
    keys = []
    for x_m in np.arange(-8.0, 3.5, 0.3):
        pose = np.array((x_m, chance.uniform(-0.05, 0.05), 0.0))
        seen = points(*scan(room, pose, chance))
        pose += chance.normal(0.0, (0.01, 0.01, math.radians(0.2)))
        keys.append(KeyScan(pose, seen, np.zeros_like(seen), 0, 0, 0))
    match = MapMatch(occupancy_of(keys))
    seen = np.concatenate([look(room, 0.3, chance).points_m for _ in range(4)])
    there = PoseInformation.of(
        match.ndt, Look(seen, np.zeros_like(seen)), np.array((0.3, 0.0, 0.0))
    )
    assert len(there.open_axes) == 1
    assert abs(there.open_axes[0][0]) > 0.999
