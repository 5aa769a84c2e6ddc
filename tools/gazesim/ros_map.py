"""A ROS map (`map.yaml` and its image, PGM) as a home: occupied cells are walls."""

from __future__ import annotations

import math
import random
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray
from gazechair.sensing.mapping.stored.home_map import MapError
from gazechair.sensing.mapping.stored.ros_map import cells
from gazesim.home_routes import Router
from gazesim.homes import Home

Grid = NDArray[np.float64]
Segment = tuple[float, float, float, float]

_PLACES = 8
_TRIES = 400
_NEAR_M = 0.3
_POCKETS = 3  # the first place may be in one


def load(path: Path) -> Home:
    """The home, with random places where the chair can turn and between which it can drive.

    Raises MapError.
    """
    found = cells(path, plain=True)
    walls = np.array(_borders(found.occupied), dtype=np.float64).reshape(-1, 2, 2) * found.cell_m
    if not len(walls):
        raise MapError(f"{path}: nothing in it is occupied")
    yaw = found.yaw_rad
    turn = np.array(
        ((math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw)))  # of rows
    )
    walls = walls @ turn + (found.x_m, found.y_m)
    floor = (np.argwhere(found.free) + 0.5) * found.cell_m @ turn + (found.x_m, found.y_m)
    home = Home(path.stem, tuple(tuple(row) for row in walls.reshape(-1, 4).tolist()))
    home.places = _places(home, floor)
    if not home.places:
        raise MapError(f"{path}: nowhere in it is room for the chair")
    home.start = (*next(iter(home.places.values())), 0.0)
    return home


def _borders(taken: BoolArray) -> list[Segment]:
    """The borders of the occupied cells, joined where they go straight on; in cells."""
    padded = np.pad(taken, 1)
    found: list[Segment] = []
    for across in (False, True):
        grid = padded.T if across else padded
        lines, places = np.nonzero(grid[1:] != grid[:-1])
        for line in np.unique(lines):
            along = places[lines == line]
            cuts = np.flatnonzero(np.diff(along) != 1) + 1
            for run in np.split(along, cuts):
                first, last = float(run[0] - 1), float(run[-1])
                if across:
                    found.append((first, float(line), last, float(line)))
                else:
                    found.append((float(line), first, float(line), last))
    return found


def _places(home: Home, floor: Grid) -> dict[str, tuple[float, float]]:
    """Places on the free floor, far apart, and each with a route to the first."""
    router = Router(home)
    chance = random.Random(home.name)
    drawn = []
    for x, y in floor[chance.sample(range(len(floor)), min(len(floor), _TRIES))]:
        place = router.place(x, y)
        if place is not None and math.dist(place, (x, y)) < _NEAR_M:
            drawn.append(place)
    best: list[tuple[float, float]] = []
    for first in drawn[:_POCKETS]:
        costs = router.costs_to(*first)
        reached = [place for place in drawn if router.reaches(costs, *place)]
        found = [first]
        while len(found) < _PLACES:
            apart = [min(math.dist(one, other) for other in found) for one in reached]
            if max(apart, default=0.0) < 1.0:
                break
            found.append(reached[apart.index(max(apart))])
        best = max(best, found, key=len)
        if len(best) == _PLACES:
            break
    return {f"place {k}": place for k, place in enumerate(best)}
