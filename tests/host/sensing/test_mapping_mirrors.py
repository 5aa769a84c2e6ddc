"""A room seen in a mirror is left out of the map; a room behind a doorway stays."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.mirrors import found, without_mirrored
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazemeasure.home.localization import look, somewhere
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR
from gazesim.homes import MIRROR, Home
from gazesim.rooms import box


def seen(number: int, seed: int | None = None) -> tuple[Home, list[KeyScan], OccupancyGrid]:
    home = home_plans.home(number)
    home.people = ()
    chance = np.random.default_rng(number if seed is None else seed)
    keys = []
    for _ in range(60):
        pose = somewhere(home, chance)
        one = look(home, pose, chance, (FRONT, REAR))
        keys.append(KeyScan(pose, one.points_m, one.origins_m, 0.0, 0.0, 0.0))
    return home, keys, occupancy_of(keys)


def test_a_mirror_is_found_and_nothing_else_is_taken_for_one() -> None:
    home, keys, grid = seen(13)
    true = [solid.corners for solid in home.solids() if solid.material == MIRROR]
    mirrors = found(keys, grid)
    assert len(mirrors) == len(true) == 1
    across = [corner[mirrors[0].axis] for corner in true[0]]
    along = [corner[1 - mirrors[0].axis] for corner in true[0]]
    assert mirrors[0].at_m == pytest.approx(np.mean(across), abs=0.04)
    ends = mirrors[0].low_m, mirrors[0].high_m
    assert ends == pytest.approx((min(along), max(along)), abs=0.25)
    assert outside_of(home, grid) > 100
    assert outside_of(home, occupancy_of(without_mirrored(keys, grid))) < 30


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(6, id="at its end nothing is seen"),
        pytest.param(14, id="few beams cross a bin, and some of them match nothing"),
        pytest.param(55, id="some furniture is seen in it only"),
        pytest.param(41, id="much of what it shows is seen in no other way"),
        pytest.param(76, id="it shows little but walls at right angles to it"),
    ],
)
def test_a_mirror_is_found_where_little_is_seen_of_its_wall(number: int) -> None:
    home, keys, grid = seen(number)
    (true,) = (solid.corners for solid in home.solids() if solid.material == MIRROR)
    (mirror,) = found(keys, grid)
    low, high = np.min(true, axis=0), np.max(true, axis=0)
    axis = mirror.axis
    assert low[axis] - 0.06 < mirror.at_m < high[axis] + 0.06
    assert low[1 - axis] - 0.1 < mirror.low_m < mirror.high_m < high[1 - axis] + 0.1
    assert outside_of(home, grid) > 10
    assert outside_of(home, occupancy_of(without_mirrored(keys, grid))) == 0


def test_two_mirrors_on_one_wall_that_show_the_same_room_are_both_found() -> None:
    home, keys, grid = seen(84, seed=0)
    true = sorted(
        np.mean(solid.corners, axis=0)[0] for solid in home.solids() if solid.material == MIRROR
    )
    middles = sorted(0.5 * (one.low_m + one.high_m) for one in found(keys, grid))
    assert middles == pytest.approx(true, abs=0.15)
    assert outside_of(home, grid) > 100
    assert outside_of(home, occupancy_of(without_mirrored(keys, grid))) == 0


def test_the_middle_of_a_symmetrical_room_is_no_mirror() -> None:
    corners = ((0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0))
    walls = tuple((*a, *b) for a, b in pairwise(corners))
    home = Home("room", walls, (box(1.9, 2.4, 0.3, 0.5, 0.0, 1.0, "cupboard"),))
    chance = np.random.default_rng(1)
    keys = []
    for part in np.linspace(0.0, 1.0, 24):  # along one of its sides only
        pose = np.array((2.7 + 0.6 * part, 0.7 + 2.6 * abs(np.sin(6.0 * part)), 6.0 * part))
        one = look(home, pose, chance, (FRONT, REAR))
        keys.append(KeyScan(pose, one.points_m, one.origins_m, 0.0, 0.0, 0.0))
    assert found(keys, occupancy_of(keys)) == []


def outside_of(home: Home, grid: OccupancyGrid) -> int:
    """How many occupied cells lie outside of the home."""
    rows = home.segments(0.25).reshape(-1, 2)
    stands = grid.occupied_m()
    low, high = rows.min(axis=0) - 0.1, rows.max(axis=0) + 0.1
    return int(((stands < low) | (stands > high)).any(axis=1).sum())
