"""Maps kept current by drives, under damage, full disks, power cuts, clocks and several at once.

Judged by the promises of docs/map.md, from the map, and from how many updates can be undone.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fulldisk import full
from gazechair.sensing.mapping import keeping
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.keeping import APART_S
from gazechair.sensing.mapping.stored import home_map
from gazechair.sensing.mapping.stored.home_map import load
from gazechair.sensing.mapping.stored.places import EditRefused
from gazechair.sensing.mapping.stored.store import MapStore
from keepingrig import Drives, home

DAY_S = 86_400.0
WHEN = "2026-11-23T10:00:00Z"
DAMAGES: dict[str, Callable[[bytes], bytes | None]] = {
    "erased": lambda _: None,
    "flash erased": lambda data: b"\xff" * len(data),
    "cut": lambda data: data[: len(data) // 2],
    "empty": lambda _: b"",
    "one bit": lambda data: data[:40] + bytes([data[40] ^ 1]) + data[41:],
}


@pytest.fixture
def drives(tmp_path: Path) -> Drives:
    return Drives(tmp_path)


def day(drives: Drives, seconds: int = 70) -> None:
    """One drive, on a later day than the one before."""
    drives.utc_s += DAY_S
    drives.start()
    drives.go(seconds)


def damage(path: Path, how: str) -> None:
    data = DAMAGES[how](path.read_bytes())
    path.unlink()
    if data is not None:
        path.write_bytes(data)


def version(was: OccupancyGrid, number: int) -> OccupancyGrid:
    hits = was.hits.copy()
    hits[0, 0] = 100 + number
    return OccupancyGrid(was.cell_m, was.low_m, hits, was.passes)


def seven_versions(store: MapStore) -> list[OccupancyGrid]:
    """After six updates; the newest last."""
    stored = store.get("a")
    assert stored is not None
    assert stored.map is not None
    grids = [stored.map.grid]
    for number in range(6):
        grids.append(version(grids[0], number))
        assert store.update("a", grids[-2], grids[-1], WHEN)
    return grids


def taken_back(folder: Path) -> list[int]:
    """The versions that undoing returns, until there are none left."""
    store = MapStore(folder)
    found: list[int] = []
    while store.updates("a") and len(found) < 10:
        try:
            if not store.take_back("a"):
                break
            found.append(int(load(folder / "a.map").grid.hits[0, 0]) - 100)
        except EditRefused as error:
            found.append(-1 if error.reason == "map_older_damaged" else -2)
    assert not store.take_back("a")
    return found


@pytest.mark.parametrize("how", DAMAGES)
def test_what_drives_found_is_damaged_and_they_begin_anew(drives: Drives, how: str) -> None:
    day(drives)
    day(drives)
    damage(drives.store.ledger_path("a"), how)
    day(drives)
    day(drives)
    assert drives.stored().same_as(drives.first)
    day(drives)
    assert not drives.stored().same_as(drives.first)


@pytest.mark.parametrize("how", DAMAGES)
def test_an_earlier_version_that_is_damaged_costs_only_itself(
    drives: Drives, how: str, tmp_path: Path
) -> None:
    grids = seven_versions(drives.store)
    damage(tmp_path / "older" / "a.5", how)
    assert drives.stored().same_as(grids[-1])
    assert taken_back(tmp_path) == [4, *([] if how == "erased" else [-1]), 2, 1, 0]


def test_a_disk_that_is_full_for_an_hour_costs_no_version(
    drives: Drives, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grids = seven_versions(drives.store)
    drives.first = grids[-1]
    day(drives)
    day(drives)

    monkeypatch.setattr(home_map, "replace_file", full)
    monkeypatch.setattr(keeping, "DRIVE_S", 3600.0)
    day(drives, 1200)
    assert drives.stored().same_as(grids[-1])
    assert drives.store.updates("a") == 5
    monkeypatch.undo()
    drives.go(70)  # the same drive
    assert drives.stored().occupied[30, 18:22].all()
    assert drives.store.updates("a") == 5
    assert drives.store.take_back("a")
    assert drives.stored().same_as(grids[-1])
    assert taken_back(tmp_path) == [4, 3, 2, 1]


class Cut(BaseException):
    """Raised when the simulated power is cut."""


def cut_at(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cut the power before the folder's `number`-th change."""
    left = [number]

    def instead(act: Callable[..., Any]) -> Callable[..., Any]:
        def cut(*values: Any, **more: Any) -> Any:
            left[0] -= 1
            if left[0] <= 0:
                raise Cut
            return act(*values, **more)

        return cut

    for name in ("link", "replace", "unlink", "fsync"):
        monkeypatch.setattr(os, name, instead(getattr(os, name)))


def act_and_cut(act: Callable[[], object], number: int) -> bool:
    """True if it was done before the power was cut."""
    with pytest.MonkeyPatch.context() as patched:
        cut_at(number, patched)
        try:
            act()
        except Cut:
            return False
    return True


def test_power_is_cut_anywhere_in_an_update(tmp_path: Path) -> None:
    for number in range(1, 40):
        folder = tmp_path / str(number)
        drives = Drives(folder)
        grids = seven_versions(drives.store)
        newest = version(grids[0], 6)
        done = act_and_cut(lambda: drives.store.update("a", grids[-1], newest, WHEN), number)  # noqa: B023
        found = load(folder / "a.map").grid
        assert found.same_as(newest) or (found.same_as(grids[-1]) and not done)
        if number % 2:
            MapStore(folder).draw("a", "home", {"x": 1, "y": 1, "heading": 0})
        back = taken_back(folder)
        assert back[: 5 if found.same_as(newest) else 4] == (
            [5, 4, 3, 2, 1] if found.same_as(newest) else [4, 3, 2, 1]
        ), number
        if done:
            return
    raise AssertionError("it never ends")


def test_power_is_cut_anywhere_in_taking_back(tmp_path: Path) -> None:
    for number in range(1, 40):
        folder = tmp_path / str(number)
        drives = Drives(folder)
        grids = seven_versions(drives.store)
        done = act_and_cut(lambda: drives.store.take_back("a"), number)  # noqa: B023
        found = load(folder / "a.map").grid
        assert found.same_as(grids[-2]) or (found.same_as(grids[-1]) and not done)
        rest = [3, 2, 1, 0] if found.same_as(grids[-2]) else [4, 3, 2, 1, 0]
        assert taken_back(folder) == rest, number
        if done:
            return
    raise AssertionError("it never ends")


def test_a_map_that_is_damaged_is_updated_from_the_version_before_and_that_can_be_had_back(
    drives: Drives, tmp_path: Path
) -> None:
    drives.store.rename("a", "here")
    (tmp_path / "a.map").write_bytes(b"\xff" * 500)
    newer = version(drives.first, 1)
    assert drives.store.update("a", drives.first, newer, WHEN)
    assert drives.stored().same_as(newer)
    assert drives.store.take_back("a")
    assert drives.stored().same_as(drives.first)


def test_a_map_that_is_deleted_while_a_drive_notes_leaves_nothing(
    drives: Drives, tmp_path: Path
) -> None:
    day(drives)
    day(drives, 50)
    drives.store.delete("a")
    drives.go(200)
    assert [one for one in tmp_path.rglob("*") if one.is_file()] == []


def test_a_map_that_is_renamed_and_drawn_on_while_a_drive_notes_keeps_all(
    drives: Drives,
) -> None:
    for number in range(3):
        day(drives, 40)
        drives.store.rename("a", f"name {number}")
        place = {"name": f"{number}", "icon": "bed", "x": 1.0, "y": 1.0, "heading": 0.0}
        drives.store.draw("a", "place", place)
        drives.go(40)
    found = drives.store.get("a")
    assert found is not None
    assert found.map is not None
    assert found.map.name == "name 2"
    assert len(found.map.drawn.places) == 3
    assert found.map.updated == "1970-01-04T20:00:00Z"
    assert not found.map.grid.same_as(drives.first)


@pytest.mark.parametrize("same_place", [True, False])
def test_another_home_under_the_same_name_of_its_file_takes_over_nothing(
    drives: Drives, tmp_path: Path, same_place: bool
) -> None:
    day(drives)
    day(drives)
    seven_versions(drives.store)
    (tmp_path / "a.map").unlink()
    grid = version(home().grid, 77)
    if not same_place:
        grid = OccupancyGrid(grid.cell_m, grid.low_m + 1.0, grid.hits, grid.passes)
    replace(home(), name="other", grid=grid, made=WHEN).save(tmp_path / "a.map")
    assert not drives.store.take_back("a")
    assert drives.store.updates("a") == 0
    drives.first = drives.stored()
    day(drives)
    assert drives.stored().same_as(grid)


@pytest.mark.parametrize("hours", [-3, -30_000, 3, 30_000])
def test_a_clock_that_is_set_during_a_drive_makes_no_other_drive_of_it(
    drives: Drives, hours: int
) -> None:
    drives.utc_s += 100_000 * 3600.0
    for _ in range(4):
        drives.go(1000)
        drives.utc_s += hours * 3600.0
    assert drives.counted() == 1


def test_a_clock_that_is_set_back_and_a_restart_make_no_other_drive(drives: Drives) -> None:
    drives.go(200)
    for _ in range(3):
        drives.utc_s -= 3 * 3600.0
        drives.start()
        drives.go(200)
    assert drives.counted() == 1


def test_a_clock_that_was_far_ahead_once_does_not_end_it_for_good(drives: Drives) -> None:
    right_s = drives.utc_s
    drives.utc_s = right_s + 14 * 365 * DAY_S
    drives.go(70)
    drives.utc_s = right_s + DAY_S
    drives.start()
    drives.go(70)
    assert drives.counted() == 1
    drives.now_s += APART_S
    drives.utc_s += APART_S
    drives.go(70)
    assert drives.counted() == 2


def test_what_is_taken_back_while_the_drive_goes_on_stays_back(
    drives: Drives, tmp_path: Path
) -> None:
    for _ in range(3):
        day(drives)
    assert not drives.stored().same_as(drives.first)
    assert MapStore(tmp_path).take_back("a")  # another process
    drives.go(300)
    assert drives.stored().same_as(drives.first)
    day(drives)
    day(drives)
    assert drives.stored().same_as(drives.first)


def test_who_draws_while_updates_are_stored_and_taken_back_loses_nothing(
    drives: Drives, tmp_path: Path
) -> None:
    grids = [drives.first, version(drives.first, 1)]
    done = threading.Event()

    def change() -> None:
        other = MapStore(tmp_path)
        while not done.is_set():
            other.update("a", grids[0], grids[1], WHEN)
            other.take_back("a")

    thread = threading.Thread(target=change)
    thread.start()
    for number in range(20):
        place = {"name": f"{number}", "icon": "bed", "x": 1.0, "y": 1.0, "heading": 0.0}
        drives.store.draw("a", "place", place)
    done.set()
    thread.join()
    found = load(tmp_path / "a.map")
    assert [one.name for one in found.drawn.places] == [f"{number}" for number in range(20)]
    assert any(found.grid.same_as(one) for one in grids)
    assert np.array_equal(MapStore(tmp_path).all()[0].map.grid.hits, found.grid.hits)  # type: ignore[union-attr]
