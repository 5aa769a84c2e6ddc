"""What the host answers about a small map, and where the chair is in it."""

import numpy as np

from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.picture import drawn

CELLS = np.full((80, 60), 5, dtype=np.uint16)
CELLS[0] = 0
GRID = OccupancyGrid(0.1, np.array((-1.0, -2.0)), 5 - CELLS, CELLS)
PICTURE = drawn(HomeMap("Thuis", GRID))
# After an update: walls where there was floor.
CHANGED = drawn(HomeMap("Thuis", OccupancyGrid(0.1, GRID.low_m, CELLS, 5 - CELLS)))
ROW = {
    "map": "a1",
    "name": "Thuis",
    "made": "2026-11-22T20:00:00Z",
    "floor_m2": 40,
    "updates": 0,
    "updated": "",
    "problem": "",
}
NOTHING = {"places": [], "no_go": [], "home": None}
DETAILS = {**ROW, "picture": PICTURE.as_json(), **NOTHING}
AT = {"x": 3.0, "y": 1.0, "heading": 90.0, "sigma": 0.02, "sigma_deg": 0.5}
WHERE = {"map": "a1", "version": 7, **AT}
