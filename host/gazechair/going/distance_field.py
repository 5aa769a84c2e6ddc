"""Distance transform of a grid, and a footprint as a cover of discs: clearance of any pose.

The clearance of a pose is the least of (distance at a disc's centre - its radius): one look-up for
each disc. The discs lie within the outline and leave less than a centimetre of it uncovered.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray, FloatArray, Int32Array
from gazechair.base.footprint import distance_m, inside

Distances = NDArray[np.float32]

_COVERED_M = 0.01
_CANDIDATE_M = 0.02
_LEAST_RADIUS_M = 0.015
_OUTLINE_M = 0.02
_INNER_M = 0.05


def distances(occupied: BoolArray, cell_m: float, most_m: float) -> Distances:
    """Metres from each cell's centre to the nearest occupied one's, exact up to `most_m`."""
    most = int(np.ceil(most_m / cell_m))
    across = _along_rows(occupied, most + 1).astype(np.float32) ** 2
    least = np.full(occupied.shape, float((most + 1) ** 2), dtype=np.float32)
    count = len(occupied)
    for shift in range(-min(most, count - 1), min(most, count - 1) + 1):
        to = slice(max(0, -shift), min(count, count - shift))
        of = slice(max(0, shift), min(count, count + shift))
        np.minimum(least[to], across[of] + np.float32(shift * shift), out=least[to])
    return np.minimum(np.sqrt(least) * np.float32(cell_m), np.float32(most_m))


def _along_rows(occupied: BoolArray, most: int) -> Int32Array:
    """Cells to the nearest occupied one of the same row."""
    columns = np.arange(occupied.shape[1], dtype=np.int32)
    far = np.int32(1 << 20)
    before = np.maximum.accumulate(np.where(occupied, columns, -far), axis=1)
    after = np.where(occupied, columns, far)[:, ::-1]
    after = np.minimum.accumulate(after, axis=1)[:, ::-1]
    return np.minimum(np.minimum(columns - before, after - columns), most).astype(np.int32)


def discs_of(outline: FloatArray) -> FloatArray:
    """Rows x, y, radius: discs within the polygon that cover it but for a centimetre."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    centres = _grid_within(outline, low, high, _CANDIDATE_M)
    radii = distance_m(outline, centres)
    kept = radii >= _LEAST_RADIUS_M
    centres, radii = centres[kept], radii[kept]
    targets = np.concatenate(
        (_along(outline, _OUTLINE_M), _grid_within(outline, low, high, _INNER_M))
    )
    gaps = np.hypot(
        centres[:, None, 0] - targets[None, :, 0], centres[:, None, 1] - targets[None, :, 1]
    )
    covers = gaps <= radii[:, None] + _COVERED_M
    left = covers.any(axis=0)
    chosen = []
    while left.any():
        best = int((covers & left).sum(axis=1).argmax())
        chosen.append(best)
        left &= ~covers[best]
    return np.column_stack((centres[chosen], radii[chosen]))


def _grid_within(
    outline: FloatArray, low: FloatArray, high: FloatArray, step_m: float
) -> FloatArray:
    xs, ys = (np.arange(low[k] + 0.5 * step_m, high[k], step_m) for k in (0, 1))
    points = np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=2).reshape(-1, 2)
    return np.asarray(points[inside(outline, points)])


def _along(outline: FloatArray, step_m: float) -> FloatArray:
    ends = np.roll(outline, -1, axis=0)
    found = []
    for a, b in zip(outline, ends, strict=True):
        count = max(1, int(np.ceil(np.hypot(*(b - a)) / step_m)))
        found.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.concatenate(found)
