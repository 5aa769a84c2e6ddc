"""Correlative search: finds where a scan fits a likelihood field best, in a window of any size.

Branch and bound: blocks of shifts are bounded by a coarse level of the field, and only those that
can still beat the best are divided. The result is the best pose of the window's grid, not merely a
good one nearby (Olson 2009; Hess et al., Real-time loop closure in 2D LIDAR SLAM, 2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import FloatArray, IntArray
from gazechair.sensing.mapping.matching.likelihood_field import LikelihoodField

_LOOKUPS_AT_ONCE = 60_000  # what fits into a processor's cache
_DEPTH_FIRST = 24  # blocks followed down first, so that there is a score to beat
_PIECE = 100_000  # blocks divided at once, for memory's sake
_MOST_BLOCKS = 1_000_000  # six times what homes need; more means noise without a clear best
_SAME_RAD = math.radians(30.0)


@dataclass(frozen=True)
class Candidate:
    """A pose and how well the scan fits there."""

    pose: FloatArray
    """(3,): x, y in metres, heading in radians."""
    score: float
    """Mean of the field over the scan's points, 0..1."""


class _Window:
    """The scan at every heading, its origin at the window's corner, on the field around it."""

    def __init__(self, field: LikelihoodField, base: IntArray, spans: IntArray) -> None:
        """`base` (headings, points, 2): cells; `spans` (2,): the window's shifts."""
        self.spans = spans
        low, high = base.min(axis=(0, 1)), base.max(axis=(0, 1)) + spans
        parts = [field.part(level, low, high) for level in range(len(field.levels))]
        self._values = [part.ravel() for part in parts]
        self._row = parts[0].shape[1]
        self._base = (base[..., 0] - low[0]) * self._row + base[..., 1] - low[1]

    def bounds(self, level: int, blocks: IntArray) -> FloatArray:
        """Upper bounds of the scores of all shifts within each block (heading, shifts)."""
        found = np.empty(len(blocks))
        shifts = blocks[:, 1] * self._row + blocks[:, 2]
        values, points = self._values[level], self._base.shape[1]
        piece = max(1, _LOOKUPS_AT_ONCE // max(1, points))
        for at in range(0, len(blocks), piece):
            part = slice(at, at + piece)
            cells = self._base.take(blocks[part, 0], axis=0)
            cells += shifts[part, None]
            # No cell lies outside: "clip" saves looking for such.
            found[part] = values.take(cells, mode="clip").sum(axis=1)
        found /= points
        return found


def search(
    field: LikelihoodField,
    points_m: FloatArray,
    low_m: FloatArray,
    high_m: FloatArray,
    headings_rad: FloatArray,
    least: float,
    apart_m: float = math.inf,
    ratio: float = 1.0,
    most: int = 1000,
) -> list[Candidate]:
    """Best fits of `points_m` (N, 2) with the scan's origin between `low_m` and `high_m` (x, y).

    Best first, `most` at most; no score below `least` or `ratio` times the best; of any two
    candidates one is `apart_m` from the other or turned by 30 degrees. None in a field of noise.
    """
    turned = _turned(points_m, headings_rad)
    spans = np.ceil((high_m - low_m) / field.cell_m).astype(np.int64) + 1
    window = _Window(field, field.cells(low_m + turned), spans)
    top = len(field.levels) - 1
    steps = [np.arange(0, span, 1 << top) for span in spans]
    grid = np.meshgrid(np.arange(len(headings_rad)), *steps, indexing="ij")
    blocks: IntArray = np.stack(grid, axis=-1).reshape(-1, 3)
    bounds = window.bounds(top, blocks)
    keep = bounds >= least
    blocks, bounds = blocks[keep], bounds[keep]
    if not len(blocks):
        return []
    first = np.argsort(-bounds)[:_DEPTH_FIRST]
    reached = _depth_first(window, top, blocks[first], bounds[first])
    enough = max(least, ratio * reached)
    for level in range(top - 1, -1, -1):
        blocks, bounds = _better(window, level, blocks[bounds >= enough], enough)
        if not 0 < len(blocks) <= _MOST_BLOCKS:
            return []
    order = np.argsort(-bounds)
    order = order[bounds[order] >= max(least, ratio * float(bounds[order[0]]))]
    blocks, scores = blocks[order], bounds[order]
    poses = np.column_stack((low_m + blocks[:, 1:] * field.cell_m, headings_rad[blocks[:, 0]]))
    return _apart(poses, scores, apart_m, most)


def _turned(points_m: FloatArray, headings_rad: FloatArray) -> FloatArray:
    c, s = np.cos(headings_rad)[:, None], np.sin(headings_rad)[:, None]
    x, y = points_m[:, 0], points_m[:, 1]
    return np.stack((c * x - s * y, s * x + c * y), axis=-1)


def _depth_first(window: _Window, top: int, blocks: IntArray, bounds: FloatArray) -> float:
    # Follow a few blocks down to single shifts: a lower bound of the best score.
    for level in range(top - 1, -1, -1):
        blocks = _divided(blocks, 1 << level, window.spans)
        bounds = window.bounds(level, blocks)
        kept = np.argsort(-bounds)[:_DEPTH_FIRST]
        blocks, bounds = blocks[kept], bounds[kept]
    return float(bounds.max())


def _better(
    window: _Window, level: int, blocks: IntArray, enough: float
) -> tuple[IntArray, FloatArray]:
    """The blocks' parts that are good enough, and their bounds."""
    found: list[IntArray] = [blocks[:0]]
    scores: list[FloatArray] = [np.zeros(0)]
    count = 0
    for at in range(0, len(blocks), _PIECE):
        parts = _divided(blocks[at : at + _PIECE], 1 << level, window.spans)
        bounds = window.bounds(level, parts)
        good = bounds >= enough
        found.append(parts[good])
        scores.append(bounds[good])
        count += int(good.sum())
        if count > _MOST_BLOCKS:
            break
    return np.concatenate(found), np.concatenate(scores)


def _divided(blocks: IntArray, half: int, spans: IntArray) -> IntArray:
    corners = np.array([(0, 0, 0), (0, half, 0), (0, 0, half), (0, half, half)])
    parts = (blocks[:, None, :] + corners).reshape(-1, 3)
    return np.asarray(parts[(parts[:, 1] < spans[0]) & (parts[:, 2] < spans[1])])


def _apart(poses: FloatArray, scores: FloatArray, apart_m: float, most: int) -> list[Candidate]:
    chosen: list[Candidate] = []
    left = np.ones(len(poses), dtype=np.bool_)
    while left.any() and len(chosen) < most:
        at = int(np.argmax(left))
        chosen.append(Candidate(poses[at], float(scores[at])))
        near = np.hypot(*(poses[:, :2] - poses[at, :2]).T) < apart_m
        off = np.abs(half_turn_rad(poses[:, 2] - poses[at, 2]))
        left &= ~(near & ((off < _SAME_RAD) | math.isinf(apart_m)))
    return chosen
