"""Stored maps that drives update: what is drawn stays, and an update can be taken back."""

from __future__ import annotations

from pathlib import Path

import pytest

from fulldisk import full
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored import home_map
from gazechair.sensing.mapping.stored.store import MapStore
from storedmaps import BED, home, refused

WHEN = "2026-11-23T10:00:00Z"


@pytest.fixture
def store(tmp_path: Path) -> MapStore:
    home().save(tmp_path / "a.map")
    home("other").save(tmp_path / "b.map")
    return MapStore(tmp_path)


def moved(store: MapStore) -> OccupancyGrid:
    """The grid of map a, with something new in it."""
    grid = store.get("a").map.grid  # type: ignore[union-attr]
    hits = grid.hits.copy()
    hits[20, int(hits[20].argmin())] = 9
    return OccupancyGrid(grid.cell_m, grid.low_m, hits, grid.passes)


def grid_of(store: MapStore) -> OccupancyGrid:
    return store.get("a").map.grid  # type: ignore[union-attr]


def test_an_update_keeps_what_is_drawn_and_can_be_taken_back(store: MapStore) -> None:
    store.draw("a", "place", BED)
    first, second = grid_of(store), moved(store)
    versions = [store.version("a"), store.version("a")]
    assert versions[0] == versions[1]
    assert store.update("a", first, second, WHEN)
    versions[0] = store.version("a")
    assert grid_of(store).same_as(second)
    store.rename("a", "later")
    assert store.take_back("a")
    assert len({*versions, store.version("a"), store.version("gone")}) == 4
    found = store.get("a")
    assert found is not None
    assert found.map is not None
    assert found.map.grid.same_as(first)
    assert found.map.name == "later"
    assert [one.name for one in found.map.drawn.places] == ["Bed"]
    assert not store.take_back("a")
    assert refused(store.update, "gone", first, second, WHEN) == "map_gone"


def test_an_update_of_a_map_that_has_changed_meanwhile_is_none(store: MapStore) -> None:
    first, second = grid_of(store), moved(store)
    assert store.update("a", first, second, WHEN)
    assert not store.update("a", first, first, WHEN)
    assert grid_of(store).same_as(second)


def test_the_newest_five_updates_can_be_taken_back_and_go_with_the_map(
    store: MapStore, tmp_path: Path
) -> None:
    grids = [grid_of(store)]
    for _ in range(7):
        grids.append(moved(store))
        assert store.update("a", grids[-2], grids[-1], WHEN)
    for grid in grids[-2:-5:-1]:
        assert store.take_back("a")
        assert grid_of(store).same_as(grid)
    assert len(list((tmp_path / "older").iterdir())) == 2
    assert store.update("a", grid_of(store), grids[0], WHEN)
    store.ledger_path("a").parent.mkdir()
    store.ledger_path("a").write_bytes(b"x")
    store.delete("a")
    left = [one.name for one in tmp_path.rglob("*") if one.is_file()]
    assert left == ["b.map"]


def test_a_disk_that_is_full_leaves_the_map_as_it_was(
    store: MapStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    first, second = grid_of(store), moved(store)

    monkeypatch.setattr(home_map, "replace_file", full)
    assert refused(store.update, "a", first, second, WHEN) == "map_not_stored"
    monkeypatch.undo()
    assert grid_of(store).same_as(first)
