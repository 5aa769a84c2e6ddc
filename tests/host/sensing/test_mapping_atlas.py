"""Several maps: after reading each, the process sends a sign of life."""

from __future__ import annotations

import numpy as np

from gazechair.sensing.mapping.atlas import Atlas
from gazechair.sensing.mapping.occupancy_grid import OccupancyGrid


def grid(wall: int) -> OccupancyGrid:
    hits = np.zeros((40, 40), dtype=np.uint16)
    hits[wall] = 5
    return OccupancyGrid(0.05, np.zeros(2), hits, np.where(hits, 0, 5).astype(np.uint16))


def test_each_map_that_is_read_is_a_sign_of_life_also_when_the_chairs_own_is_gone() -> None:
    told: list[tuple[str, bool]] = []
    atlas = Atlas(lambda: told.append((atlas.id, atlas.location is not None)))
    atlas.know({"a": grid(0), "b": grid(5)})
    assert told == [("", False)] * 2
    atlas.place("a", np.array((1.0, 1.0, 0.0)), np.zeros(3), 0)
    atlas.know({"a": grid(0), "b": grid(6)})
    assert told[2:] == [("a", True)]
    atlas.know({"b": grid(7), "c": grid(8)})
    assert told[3:] == [("", False)] * 2
    assert atlas.ids == ["b", "c"]
