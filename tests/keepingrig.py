"""A chair that keeps its stored map current: drives past something new, in virtual time."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.keeping import APART_S, Keeping
from gazechair.sensing.mapping.locating.location import Location
from gazechair.sensing.mapping.locating.looks import Seen
from gazechair.sensing.mapping.locating.map_match import Evidence, Look
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.sensing.mapping.upkeep import load_ledger
from gazechair.sensing.odometry.estimate import Estimate

LOCATION = Location(np.array((1.0, 1.0, 0.0)), Evidence(1.0, 0.0), 0.01, 0.01)
AHEAD = Look(np.array([(0.5, y) for y in np.arange(-0.1, 0.11, 0.02)]), np.zeros((11, 2)))


def home() -> HomeMap:
    """2 m by 2 m, with a wall along one side."""
    hits = np.zeros((40, 40), dtype=np.uint16)
    hits[0] = 5
    passes = np.where(hits, 0, 5).astype(np.uint16)
    return HomeMap("home", OccupancyGrid(0.05, np.zeros(2), hits, passes))


def estimate(at_s: float) -> Estimate:
    return Estimate(at_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1, 1.0, (), 0)


class Drives:
    """Something new stands ahead of a chair at (1, 1) of a map; looks a second apart."""

    def __init__(self, folder: Path) -> None:
        home().save(folder / "a.map")
        self.store = MapStore(folder)
        self.utc_s = 10 * APART_S
        self.now_s = 0.0
        self.first = self._grid = self.stored()
        self.start()

    def stored(self) -> OccupancyGrid:
        return self.store.get("a").map.grid  # type: ignore[union-attr]

    def start(self) -> None:
        self.keeping = Keeping(self.store, lambda: self.utc_s)

    def go(self, seconds: int, unsure_every: int = 1000) -> None:
        for step in range(seconds):
            self.now_s += 1.0
            seen = Seen(AHEAD, np.array((0.2 * step, 0.0, 0.0)), estimate(self.now_s))
            if step % unsure_every == unsure_every - 1:
                self.keeping.unsure()
            known = self.store.get("a")
            if known is not None and known.map is not None:
                grid = known.map.grid  # as Atlas does: an unchanged grid is kept
                self._grid = self._grid if self._grid.same_as(grid) else grid
            self.keeping.look("a", self._grid, seen, LOCATION)

    def counted(self) -> int:
        return int(load_ledger(self.store.ledger_path("a"), self.first).taken.max())
