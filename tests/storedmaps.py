"""Small stored maps, for tests of what keeps them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.places import EditRefused

BED = {"name": "Bed", "icon": "bed", "x": 1.0, "y": 0.5, "heading": -90.0}


def home(name: str = "home") -> HomeMap:
    """2 m by 2 m, with a wall along one side."""
    hits = np.zeros((40, 40), dtype=np.uint16)
    hits[0] = 5
    passes = np.where(hits, 0, 5).astype(np.uint16)
    return HomeMap(name, OccupancyGrid(0.05, np.zeros(2), hits, passes), "2026-11-22T20:00:00Z")


def refused(act: Any, *values: Any) -> str:
    """The reason for which `act` is refused."""
    with pytest.raises(EditRefused) as caught:
        act(*values)
    assert str(caught.value)
    return caught.value.reason
