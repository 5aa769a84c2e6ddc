"""A ROS map (`map.yaml` and its image, PGM) as a home: occupied cells are walls."""

from __future__ import annotations

import math
import random
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gazesim.home_routes import Router
from gazesim.homes import Home

Grid = NDArray[np.float64]
Segment = tuple[float, float, float, float]

_PLACES = 8
_TRIES = 400
_NEAR_M = 0.3
_POCKETS = 3  # the first place may be in one


class MapError(Exception):
    """The map can't be used; the text is one plain line."""


def load(path: Path) -> Home:
    """The home; its places are drawn where the chair can turn and get to from one another."""
    fields = _fields(path)
    try:
        resolution_m = float(fields["resolution"])
        x_m, y_m, yaw = (float(one) for one in fields["origin"].strip("[] ").split(","))
        occupied = float(fields.get("occupied_thresh", "0.65"))
        free = float(fields.get("free_thresh", "0.196"))
        negate = fields.get("negate", "0").strip() in ("1", "true")
        image = _pgm(path.parent / fields["image"].strip("\"' "))
    except (KeyError, ValueError) as error:
        raise MapError(f"{path}: {error}") from None
    grey = image / 255.0
    taken = (grey if negate else 1.0 - grey)[::-1].T
    walls = np.array(_borders(taken > occupied), dtype=np.float64).reshape(-1, 2, 2) * resolution_m
    if not len(walls):
        raise MapError(f"{path}: nothing in it is occupied")
    turn = np.array(
        ((math.cos(yaw), math.sin(yaw)), (-math.sin(yaw), math.cos(yaw)))  # of rows
    )
    walls = walls @ turn + (x_m, y_m)
    floor = (np.argwhere(taken < free) + 0.5) * resolution_m @ turn + (x_m, y_m)
    home = Home(path.stem, tuple(tuple(row) for row in walls.reshape(-1, 4).tolist()))
    home.places = _places(home, floor)
    if not home.places:
        raise MapError(f"{path}: nowhere in it is room for the chair")
    home.start = (*next(iter(home.places.values())), 0.0)
    return home


def _fields(path: Path) -> dict[str, str]:
    try:
        lines = path.read_text().splitlines()
    except OSError as error:
        raise MapError(f"{path}: {error.strerror}") from None
    rows = (line.split("#")[0].partition(":") for line in lines)
    return {key.strip(): value.strip() for key, _, value in rows if value.strip()}


def _pgm(path: Path) -> Grid:
    """Grey values 0..255, top row first."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}") from None
    head = re.match(
        rb"(P[25])(?:\s+#[^\n]*)*\s+(\d+)(?:\s+#[^\n]*)*\s+(\d+)(?:\s+#[^\n]*)*\s+(\d+)\s", data
    )
    if head is None:
        raise ValueError(f"{path} is no PGM image")
    width, height, most = (int(one) for one in head.groups()[1:])
    if not 0 < most < 256:
        raise ValueError(f"{path}: {most} grey values are not supported")
    if head[1] == b"P5":
        values = np.frombuffer(data, dtype=np.uint8, offset=head.end())
    else:
        values = np.array(data[head.end() :].split(), dtype=np.float64)
    if len(values) < width * height:
        raise ValueError(f"{path} is cut short")
    grey = values[: width * height].astype(np.float64) * (255.0 / most)
    return grey.reshape(height, width)


def _borders(taken: NDArray[np.bool_]) -> list[Segment]:
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
