"""What later drives change in a map, and what they do not."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.map_match import Look
from gazechair.sensing.mapping.upkeep import GONE_AFTER, NEW_AFTER, Ledger, Upkeep, load_ledger
from gazesim.rooms import Person, Room, box
from homerig import flat, points, poses, scan

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("mapping_upkeep")

CHANCE = np.random.default_rng(4)
KEYS = list(poses())
ROOM = [pose for pose in KEYS if math.dist(pose[:2], (2.0, 2.0)) < 1.9]
TABLE = box(1.2, 2.4, 0.6, 0.5, 0.0, 0.8, "table")
HOUR_S = 3600.0


@pytest.fixture(scope="module")
def grid() -> OccupancyGrid:
    return occupancy_of([key(flat(), pose) for pose in KEYS])


def key(room: Room, pose: np.ndarray) -> KeyScan:
    seen = points(*scan(room, pose, CHANCE))
    return KeyScan(pose, seen, np.zeros_like(seen), 0.0, 0.0, 0.0)


def without_cupboard() -> Room:
    room = flat()
    kept = tuple(one for one in room.furniture if tuple(np.mean(one.corners, axis=0)) != (3.7, 1.8))
    assert len(kept) == len(room.furniture) - 1
    return Room("changed", room.walls, kept)


def driven(
    grid: OccupancyGrid, before: Ledger, room: Room, off: tuple[float, float, float] = (0, 0, 0)
) -> Upkeep:
    """A drive through the room; `off`: error of the pose."""
    upkeep = Upkeep(grid, before)
    for pose in ROOM:
        seen = points(*scan(room, pose, CHANCE))
        upkeep.look(Look(seen, np.zeros_like(seen)), pose + np.array(off))
    upkeep.settle()
    return upkeep


def after(grid: OccupancyGrid, *rooms: Room) -> tuple[OccupancyGrid, Ledger, list[int]]:
    """The map after a drive through each, and in which drives it was changed."""
    ledger, changed = Ledger.of(grid), []
    for number, room in enumerate(rooms, 1):
        upkeep = driven(grid, ledger, room)
        updated = upkeep.updated(HOUR_S * number)
        ledger = upkeep.ledger(HOUR_S * number)
        if updated is not None:
            grid, ledger = updated
            changed.append(number)
    return grid, ledger, changed


def taken(grid: OccupancyGrid, x: float, y: float, wide: float, deep: float) -> int:
    """Occupied cells in a box, with a hand's breadth around it."""
    off = np.abs(grid.occupied_m() - (x, y))
    return int((off < (wide / 2 + 0.05, deep / 2 + 0.05)).all(axis=1).sum())


def test_what_is_as_mapped_changes_nothing_however_often_it_is_seen(grid: OccupancyGrid) -> None:
    kept, ledger, changed = after(grid, *[flat()] * 4)
    assert changed == []
    assert kept is grid
    assert not (ledger.taken >= NEW_AFTER).any()


def test_a_new_table_is_there_after_the_third_drive_and_gone_two_drives_after_it_left(
    grid: OccupancyGrid,
) -> None:
    assert not taken(grid, 1.2, 2.4, 0.6, 0.5)
    with_table = flat(TABLE)
    found, _, changed = after(grid, *[with_table] * NEW_AFTER)
    assert changed == [NEW_AFTER]
    assert taken(found, 1.2, 2.4, 0.6, 0.5) > 15
    added = found.occupied & ~grid.occupied
    assert added.sum() == taken(found, 1.2, 2.4, 0.6, 0.5)
    assert (grid.occupied & ~found.occupied).sum() == 0
    cleared, _, changed = after(found, *[flat()] * GONE_AFTER)
    assert changed == [GONE_AFTER]
    assert not taken(cleared, 1.2, 2.4, 0.6, 0.5)
    assert np.array_equal(cleared.occupied, grid.occupied)


def test_a_cupboard_that_was_taken_away_leaves_free_floor_where_it_stood(
    grid: OccupancyGrid,
) -> None:
    assert taken(grid, 3.5, 1.8, 0.05, 0.9) > 20  # its front
    found, _, changed = after(grid, *[without_cupboard()] * GONE_AFTER)
    assert changed == [GONE_AFTER]
    assert taken(found, 3.5, 1.8, 0.05, 0.9) == 0
    inside = tuple(np.floor((np.array((3.75, 1.8)) - grid.low_m) / grid.cell_m).astype(int))
    assert not grid.free[inside]
    assert found.free[inside]
    assert not (found.occupied & ~grid.occupied).any()


def test_two_drives_and_then_one_without_it_begin_anew(grid: OccupancyGrid) -> None:
    with_table = flat(TABLE)
    _, _, changed = after(grid, with_table, with_table, flat(), with_table, with_table)
    assert changed == []


def test_people_who_stand_elsewhere_in_each_drive_leave_nothing(grid: OccupancyGrid) -> None:
    rooms = [
        flat(people=[Person(((1.0 + 0.5 * k, 2.5),)), Person(((0.7, 1.5 + 0.4 * k),))])
        for k in range(4)
    ]
    assert after(grid, *rooms)[2] == []


def test_people_who_stand_at_nearly_the_same_place_in_each_drive_leave_nothing(
    grid: OccupancyGrid,
) -> None:
    stood = ((1.2, 2.4), (1.3, 2.45), (1.15, 2.5), (1.25, 2.35))
    assert after(grid, *[flat(people=[Person((one,))]) for one in stood])[2] == []


def test_a_place_that_is_a_little_wrong_makes_no_wall_thicker(grid: OccupancyGrid) -> None:
    ledger = Ledger.of(grid)
    for off in ((0.06, 0.0, 0.0), (0.05, -0.03, 0.0), (0.06, 0.0, math.radians(0.7))):
        upkeep = driven(grid, ledger, flat(), off)
        assert upkeep.updated(HOUR_S) is None
        ledger = upkeep.ledger(HOUR_S)


def test_another_home_is_not_taken_over(grid: OccupancyGrid) -> None:
    bare = Room("bare", ((0, 0, 10, 0), (10, 0, 10, 8), (10, 8, 0, 8), (0, 8, 0, 0)))
    ledger = Ledger.of(grid)
    for number in range(3):
        upkeep = Upkeep(grid, ledger)
        for pose in KEYS[::4]:
            seen = points(*scan(bare, pose, CHANCE))
            upkeep.look(Look(seen, np.zeros_like(seen)), pose)
        upkeep.settle()
        assert upkeep.updated(HOUR_S) is None
        assert upkeep.too_much == (number >= GONE_AFTER - 1)
        ledger = upkeep.ledger(HOUR_S)


def test_looks_count_only_once_the_place_stayed_known(grid: OccupancyGrid) -> None:
    upkeep = Upkeep(grid, Ledger.of(grid))
    for pose in ROOM:
        seen = points(*scan(flat(TABLE), pose, CHANCE))
        upkeep.look(Look(seen, np.zeros_like(seen)), pose)
    assert not upkeep.ledger(0.0).taken.any()
    upkeep.drop()
    upkeep.settle()
    assert not upkeep.ledger(0.0).taken.any()


def test_what_was_found_is_read_back_but_never_for_another_map_nor_half(
    grid: OccupancyGrid, tmp_path: Path
) -> None:
    path = tmp_path / "drives" / "a"
    ledger = driven(grid, Ledger.of(grid), flat(TABLE)).ledger(HOUR_S)
    assert ledger.taken.any()
    ledger.save(path)
    read = load_ledger(path, grid)
    assert np.array_equal(read.taken, ledger.taken)
    assert np.array_equal(read.free, ledger.free)
    assert read.drive_s == HOUR_S
    hits = grid.hits.copy()
    hits[0, 0] += 1
    other = load_ledger(path, OccupancyGrid(grid.cell_m, grid.low_m, hits, grid.passes))
    assert not other.taken.any()
    assert other.drive_s == HOUR_S  # of the same drive nothing counts twice
    whole = path.read_bytes()
    for damaged in (whole[:-9], whole[:60] + b"x" + whole[61:], b"", b"gazechair-drives 1\n"):
        path.write_bytes(damaged)
        assert not load_ledger(path, grid).taken.any()
    path.unlink()
    assert not load_ledger(path, grid).taken.any()
