"""ROS maps in styles other than the project's own: a plan drawn by hand, and a robot's map.

Each is a `map.yaml` with its PGM in a folder. The drawn one has slanted walls, cells of 4 cm, and
its colours inverted; the other comes from the public log fr079, on its corrected track.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import occupancy_of
from gazemeasure import carmen_log

Grey = NDArray[np.uint8]
Floats = NDArray[np.floating[Any]]
Line = tuple[float, float, float, float, float]  # x0, y0, x1, y1 and thickness, in metres

_CELL_M = 0.04
_WHITE, _GREY, _BLACK = 254, 205, 0
_LOW_M, _HIGH_M = (-1.0, -1.0), (12.4, 9.6)
_EVERY = 12  # frames of the log
_ROBOT_CELL_M = 0.05
_FAR_M = 12.0

# A flat with a cut-off corner, a slanted hall, a bay and a round column.
_WALLS: tuple[Line, ...] = (
    (0.0, 0.0, 8.0, 0.0, 0.25), (8.0, 0.0, 11.0, 3.0, 0.25), (11.0, 3.0, 11.0, 8.2, 0.25),
    (11.0, 8.2, 3.0, 8.2, 0.25), (3.0, 8.2, 0.0, 6.0, 0.25), (0.0, 6.0, 0.0, 0.0, 0.25),
    (0.0, 3.4, 1.7, 3.4, 0.12), (2.75, 3.4, 4.3, 3.4, 0.12), (4.3, 3.4, 4.3, 1.4, 0.12),
    (4.3, 3.4, 5.1, 4.2, 0.12), (5.85, 4.95, 6.6, 5.7, 0.12), (6.6, 5.7, 6.6, 8.2, 0.12),
    (6.6, 5.7, 8.5, 5.7, 0.12), (9.6, 5.7, 11.0, 5.7, 0.12),
)  # fmt: skip
_FURNITURE: tuple[Line, ...] = (
    (0.5, 0.5, 2.2, 0.5, 0.6), (0.45, 5.4, 1.3, 5.4, 0.7), (7.1, 7.8, 8.6, 7.8, 0.5),
    (10.6, 6.6, 10.6, 7.6, 0.5), (6.4, 0.5, 7.2, 0.5, 0.5), (8.4, 3.6, 8.4, 3.6, 0.5),
)  # fmt: skip


def drawn_by_hand(folder: Path, noisy: bool) -> Path:
    """The drawn plan; `noisy`: as a robot maps it, with frayed walls, specks, unseen corners."""
    size = [round((high - low) / _CELL_M) for low, high in zip(_LOW_M, _HIGH_M, strict=True)]
    x, y = (
        low + (np.arange(count) + 0.5) * _CELL_M for low, count in zip(_LOW_M, size, strict=True)
    )
    far = np.full(tuple(size), np.inf)
    for x0, y0, x1, y1, thick in (*_WALLS, *_FURNITURE):
        dx, dy = x1 - x0, y1 - y0
        share = ((x[:, None] - x0) * dx + (y[None] - y0) * dy) / max(dx * dx + dy * dy, 1e-9)
        share = np.clip(share, 0.0, 1.0)
        off = np.hypot(x[:, None] - x0 - share * dx, y[None] - y0 - share * dy) - 0.5 * thick
        far = np.minimum(far, off)
    grey = np.where(far <= 0.0, _BLACK, _WHITE).astype(np.uint8)
    inside = _inside(x, y)
    grey[~inside & (far > 0.0)] = _GREY
    if noisy:
        chance = np.random.default_rng(7)
        edge = (np.abs(far) < _CELL_M) & inside
        frayed = edge & (chance.random(grey.shape) < 0.3)
        grey[frayed] = np.where(far[frayed] <= 0.0, _WHITE, _BLACK)
        grey[(far < -1.5 * _CELL_M)] = _GREY  # the inside of walls is unknown
        unseen = (far > 0.0) & inside & (chance.random(grey.shape) < 0.004)
        grey[unseen] = _GREY
    return _write(folder, 255 - grey, _CELL_M, _LOW_M, negate=1)


def left_by_a_robot(folder: Path) -> Path:
    """The log fr079 as a usual ROS map. Raises NoDataError."""
    keys = []
    for frame in carmen_log.read(carmen_log.FR079)[::_EVERY]:
        near = np.hypot(*frame.points_m.T) < _FAR_M
        points = frame.points_m[near]
        keys.append(KeyScan(frame.reference, points, np.zeros_like(points), 0.0, 0.0, 0.0))
    grid = occupancy_of(keys, _ROBOT_CELL_M)
    grey = np.full(grid.hits.shape, _GREY, dtype=np.uint8)
    grey[grid.free], grey[grid.occupied] = _WHITE, _BLACK
    low_m = float(grid.low_m[0]), float(grid.low_m[1])
    return _write(folder, grey, grid.cell_m, low_m, negate=0)


def _inside(x: Floats, y: Floats) -> BoolArray:
    """Within the outer walls, which are convex and go counter-clockwise."""
    found = np.ones((len(x), len(y)), dtype=np.bool_)
    for x0, y0, x1, y1, _ in _WALLS[:6]:
        found &= (x1 - x0) * (y[None] - y0) - (y1 - y0) * (x[:, None] - x0) > 0.0
    return found


def _write(
    folder: Path, grey: Grey, cell_m: float, low_m: tuple[float, float], negate: int
) -> Path:
    yaml = (
        f"image: plan.pgm\nresolution: {cell_m}\norigin: [{low_m[0]}, {low_m[1]}, 0.0]\n"
        f"negate: {negate}\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    (folder / "map.yaml").write_text(yaml)
    head = f"P5\n# drawn\n{grey.shape[0]} {grey.shape[1]}\n255\n".encode()
    (folder / "plan.pgm").write_bytes(head + np.ascontiguousarray(grey.T[::-1]).tobytes())
    return folder / "map.yaml"
