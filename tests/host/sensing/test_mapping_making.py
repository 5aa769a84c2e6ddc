"""A map that is being made ends before it is too large to be stored and read."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from gazechair.sensing.mapping import making
from gazechair.sensing.mapping.building.occupancy_grid import CELL_M
from gazechair.sensing.mapping.locating.looks import Looks, Seen
from gazechair.sensing.mapping.locating.map_match import Look
from gazechair.sensing.mapping.making import ASKEW, FULL, Making
from gazechair.sensing.mapping.stored import home_map
from gazechair.sensing.mapping.stored.home_map import HomeMap, MapError
from gazechair.sensing.odometry.doubts import CHANGED, TURNED
from gazechair.sensing.odometry.estimate import Estimate

HALL = np.array(
    [(x, side) for x in np.arange(-4.0, 4.0, 0.05) for side in (-3.0, 3.0)], dtype=np.float64
)


def looks(x_m: float, *doubts: str) -> Looks:
    """What a chair between two walls sees."""
    estimate = Estimate(x_m, x_m, 0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 1.0, doubts, 0)
    pose = np.array((x_m, 0.0, 0.0))
    seen = Seen(Look(HALL, np.zeros_like(HALL)), pose, estimate)
    found = SimpleNamespace(track=0, pose=pose, seen=lambda: seen, newest=estimate)
    return cast("Looks", found)


def driven(metres: int) -> Making:
    made = Making()
    for x_m in range(metres):
        made.take(looks(float(x_m)))
    return made


def test_a_map_that_is_as_large_as_can_be_stored_takes_no_more_and_is_saved(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert home_map.MOST_M2 / CELL_M**2 < home_map.MOST_CELLS
    monkeypatch.setattr(making, "MOST_M2", 120.0)
    made = driven(60)
    assert (made.doubt, len(made.keys)) == (FULL, 14)  # a step beyond 6 m by 20 m
    made.finished("hall").save(tmp_path / "a.map")
    assert home_map.load(tmp_path / "a.map").grid.cell_m == CELL_M


def test_what_a_lidar_that_may_be_turned_sees_is_not_mapped() -> None:
    made = driven(5)
    assert not made.take(looks(5.0, CHANGED, TURNED))
    assert not made.take(looks(6.0, TURNED))
    assert (made.doubt, len(made.keys)) == (ASKEW, 5)
    assert made.take(looks(7.0, CHANGED))
    assert (made.doubt, len(made.keys)) == ("", 6)


def test_a_map_that_grows_as_it_is_finished_gets_larger_cells(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(making, "MOST_CELLS", 50_000)
    grid = driven(10).finished("hall").grid
    assert grid.cell_m == 2.0 * CELL_M
    assert grid.hits.size <= 50_000
    assert grid.occupied.any()


def test_a_map_that_could_not_be_read_again_is_not_stored(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(home_map, "MOST_CELLS", 1000)
    home: HomeMap = driven(3).finished("hall")
    with pytest.raises(MapError, match="too many"):
        home.save(tmp_path / "a.map")
    assert list(tmp_path.iterdir()) == []
