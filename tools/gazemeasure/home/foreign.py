"""Localization in unfamiliar conditions: mirrors, glass, and maps in another style.

Mirrors and glass: in every room of a generated home a mirror and a pane on the walls, mapped, or
hung up after the map was made. Foreign maps: plans drawn by hand (slanted walls, a bay, round
pillars), as another SLAM would write them to ROS files: other cells, bent, noisy, with gaps and
specks; the chair stands in the plan itself. And the public log fr079 as such a map: an office with
many similar rooms.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.mirrors import without_mirrored
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.stored import ros_map
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazemeasure import carmen_log
from gazemeasure.home.localization import (
    Counted,
    add_right,
    key_scans,
    somewhere,
    turning,
)
from gazemeasure.report import Report
from gazesim import home_plans
from gazesim import ros_map as ros_home
from gazesim.home_drive import LIDAR_HEIGHT_M
from gazesim.homes import GLASS, MIRROR, Home
from gazesim.rooms import Solid, box

MIRRORS, HUNG, DRAWN, LOGGED = (
    "mirrors and glass in every room",
    "hung up after the map was made",
    "maps of others, by ROS's files",
    "an office from a public log",
)
# A known mirror shows what contradicts the map: there, fewer places are certain, and none is wrong.
_LEAST = {MIRRORS: 80.0, DRAWN: 90.0}
_SEEDS = {
    MIRRORS: range(100, 120),
    HUNG: range(100, 120),
    DRAWN: range(45),
    LOGGED: range(10),
}
_STARTS = 2  # of each seed
_WIDE_M, _THIN_M, _BEFORE_M = 1.0, 0.02, 0.3  # mirrors and panes; a pane stands before its wall

# Plans: closed lines, and walls within; metres.
_PLANS: tuple[tuple[tuple[tuple[float, float], ...], ...], ...] = (
    (  # under a slanted roof
        ((0, 0), (8, 0), (10.5, 2.5), (10.5, 7), (8.5, 9), (2, 9), (0, 6.2), (0, 0)),
        ((4.2, 0), (4.2, 1.1), (4.2, 2.3), (3.1, 4.2), (0, 4.2)),
        ((6.1, 9), (6.1, 6.6), (7.0, 5.4)),
        ((8.4, 3.9), (10.5, 3.9)),
        ((0.4, 0.4), (2.0, 0.4), (2.0, 1.2), (0.4, 1.2), (0.4, 0.4)),
        ((7.4, 7.6), (8.3, 8.2), (7.8, 8.9)),
    ),
    (  # with a bay
        (
            (0, 0),
            (6, 0),
            (7.2, 1.2),
            (7.2, 2.8),
            (6, 4),
            (6, 8),
            (-1.5, 8),
            (-1.5, 4),
            (0, 4),
            (0, 0),
        ),
        ((-1.5, 5.6), (1.2, 5.6)),
        ((2.4, 5.6), (6, 5.6)),
        ((3.0, 8), (3.6, 6.9)),
        ((4.8, 4.3), (5.6, 4.9)),
        ((0.3, 2.0), (1.0, 1.6), (1.5, 2.5), (0.8, 2.9), (0.3, 2.0)),
    ),
    (  # one hall with pillars, a niche and a screen
        (
            (0, 0),
            (12, 0),
            (12, 5),
            (13.5, 5),
            (13.5, 7),
            (12, 7),
            (12, 9.5),
            (5, 10.5),
            (0, 8),
            (0, 0),
        ),
        tuple(
            (4 + 0.3 * math.cos(a), 3 + 0.3 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 13)
        ),
        tuple(
            (8 + 0.4 * math.cos(a), 6 + 0.4 * math.sin(a)) for a in np.linspace(0, 2 * math.pi, 13)
        ),
        ((6.2, 0), (6.8, 2.6)),
        ((9.3, 2.0), (11.2, 2.9), (10.9, 3.5)),
        ((1.2, 5.4), (2.6, 6.6)),
    ),
)
# Errors of a SLAM map: of points, of walls, share missing, share of specks; the whole is bent.
_POINT_M, _WALL_M, _MISSING, _SPECKS = 0.012, 0.012, 0.06, 0.0006
_BENT_RAD_M, _STRETCHED = 0.0006, 0.002
_CELLS_M = (0.02, 0.05, 0.10)
_VIEWS, _BEAMS = 80, 360
_LOG_EVERY = 8  # scans of the public log

Job = tuple[str, int]  # kind, seed
Run = Callable[[Callable[[Job], Counted], Sequence[Job]], list[Counted]]


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add the rows; `run` maps jobs."""
    for kind, every in _SEEDS.items():
        seeds = every[:1] if quick else every
        try:
            done = run(starts_in, [(kind, seed) for seed in seeds])
        except carmen_log.NoDataError as error:
            report.note(f"{kind} not measured: {error}")
            continue
        add_right(report, kind, done, _LEAST.get(kind))


def starts_in(job: Job) -> Counted:
    """The results of the starts of one seed."""
    kind, seed = job
    chance = np.random.default_rng(seed)
    counted = Counted()
    home, grid = _HOMES[kind](seed, chance)
    for _ in range(_STARTS):
        found, pose, _ = turning(Localization(grid), home, somewhere(home, chance), chance)
        counted.count(kind, found, pose)
    return counted


def _mirrored(seed: int, chance: np.random.Generator) -> tuple[Home, OccupancyGrid]:
    home = with_mirrors(home_plans.home(seed), chance)
    return home, _as_made(home, chance)


def _hung(seed: int, chance: np.random.Generator) -> tuple[Home, OccupancyGrid]:
    home = home_plans.home(seed)
    home.people = ()
    grid = _as_made(home, chance)
    return with_mirrors(home, chance), grid


def _as_made(home: Home, chance: np.random.Generator) -> OccupancyGrid:
    """The map as a chair would make it: without the rooms that appear in mirrors."""
    keys = key_scans(home, chance)
    return occupancy_of(without_mirrored(keys, occupancy_of(keys)))


def with_mirrors(home: Home, chance: np.random.Generator) -> Home:
    """The home with a mirror and a pane of glass in every room that has a wall for them."""
    home.people = ()
    more: list[Solid] = []
    for x_m, y_m in home.places.values():
        sides = chance.permutation(4)
        for side, material, before_m in zip(sides, (MIRROR, GLASS), (0.0, _BEFORE_M), strict=False):
            angle = 0.5 * math.pi * float(side)
            away_m = float(home.cast(x_m, y_m, np.array([angle]), LIDAR_HEIGHT_M)[0])
            away_m -= before_m + _THIN_M
            at = x_m + away_m * math.cos(angle), y_m + away_m * math.sin(angle)
            turned = 90.0 * float(side) + 90.0
            if away_m > 1.0:
                more.append(box(*at, _WIDE_M, _THIN_M, 0.0, 2.0, material, turned))
    home.furniture = (*home.furniture, *more)
    home.changed()
    return home


def plan(number: int) -> Home:
    """A plan drawn by hand."""
    lines = _PLANS[number % len(_PLANS)]
    return Home(
        f"plan {number}", tuple((*one, *after) for line in lines for one, after in pairwise(line))
    )


def _drawn(seed: int, chance: np.random.Generator) -> tuple[Home, OccupancyGrid]:
    home = plan(seed)
    cell_m = _CELLS_M[seed // len(_PLANS) % len(_CELLS_M)]
    with tempfile.TemporaryDirectory() as folder:
        path = as_ros_map(home, cell_m, Path(folder), chance)
        return home, ros_map.read(path, home.name).grid


def as_ros_map(home: Home, cell_m: float, folder: Path, chance: np.random.Generator) -> Path:
    """Write `map.yaml` and its image as another SLAM would; returns the path."""
    walls = np.array(home.walls)
    low, high = walls.reshape(-1, 2).min(axis=0) - 1.0, walls.reshape(-1, 2).max(axis=0) + 1.0
    shape = np.ceil((high - low) / cell_m).astype(int)
    grey = np.full(tuple(shape), 205, dtype=np.uint8)

    def put(points: FloatArray, value: int) -> None:
        middle = 0.5 * (low + high)
        off = (points - middle) * (1.0 + _STRETCHED)
        bent = off + np.stack((np.zeros(len(off)), _BENT_RAD_M * off[:, 0] ** 2), axis=1)
        cells = np.floor((bent + middle - low) / cell_m).astype(int)
        cells = cells[((cells >= 0) & (cells < shape)).all(axis=1)]
        grey[cells[:, 0], cells[:, 1]] = value

    for _ in range(_VIEWS):
        x_m, y_m, _ = somewhere(home, chance)
        angles = np.linspace(0.0, 2.0 * math.pi, _BEAMS, endpoint=False)
        metres = np.minimum(home.cast(x_m, y_m, angles, LIDAR_HEIGHT_M), 8.0)
        share = np.arange(0.0, 8.0, 0.7 * cell_m)
        along = share[None] + np.zeros((_BEAMS, 1))
        seen = along < metres[:, None]
        x, y = along * np.cos(angles)[:, None], along * np.sin(angles)[:, None]
        put(np.stack((x_m + x[seen], y_m + y[seen]), axis=1), 254)
    for x1, y1, x2, y2 in walls:
        length = math.hypot(x2 - x1, y2 - y1)
        count = math.ceil(3.0 * length / cell_m) + 1
        points = np.linspace((x1, y1), (x2, y2), count) + chance.normal(0.0, _WALL_M, 2)
        points += chance.normal(0.0, _POINT_M, points.shape)
        put(points[chance.random(count) >= _MISSING], int(chance.integers(0, 60)))
    specks = np.argwhere(chance.random(grey.shape) < _SPECKS)
    grey[specks[:, 0], specks[:, 1]] = 0
    image = b"P5\n# by another\n%d %d\n255\n" % grey.shape + grey.T[::-1].tobytes()
    (folder / "slam map.pgm").write_bytes(image)
    yaml = folder / "map.yaml"
    yaml.write_text(
        f"# by another\nimage: 'slam map.pgm'\nresolution: {cell_m:.6f}\n"
        f"origin: [{low[0]}, {low[1]}, 0.0]\noccupied_thresh: 0.65\nfree_thresh: 0.25\nnegate: 0\n"
    )
    return yaml


def _logged(_seed: int, _chance: np.random.Generator) -> tuple[Home, OccupancyGrid]:
    return _office()


@lru_cache(maxsize=1)
def _office() -> tuple[Home, OccupancyGrid]:
    keys = []
    for frame in carmen_log.read(carmen_log.FR079)[::_LOG_EVERY]:
        starts = np.zeros_like(frame.points_m)
        keys.append(KeyScan(frame.reference, frame.points_m, starts, 0.0, 0.0, 0.0))
    grid = occupancy_of(keys)
    with tempfile.TemporaryDirectory() as folder:
        path = ros_map.write(HomeMap("office", grid), Path(folder))
        return ros_home.load(path), ros_map.read(path, "office").grid


_HOMES: dict[str, Callable[[int, np.random.Generator], tuple[Home, OccupancyGrid]]] = {
    MIRRORS: _mirrored,
    HUNG: _hung,
    DRAWN: _drawn,
    LOGGED: _logged,
}
