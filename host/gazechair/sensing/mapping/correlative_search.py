"""Correlative search: where a scan fits a likelihood field best, in a window however large.

Branch and bound: blocks of shifts are bounded by a coarse level of the field, and only those that
can still beat the best are divided. The result is the best pose of the window's grid, not merely a
good one nearby (Olson 2009; Hess et al., Real-time loop closure in 2D LIDAR SLAM, 2016).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.sensing.mapping.likelihood_field import Ints, LikelihoodField

_LOOKUPS_AT_ONCE = 60_000  # what fits into a processor's cache
_DEPTH_FIRST = 24  # blocks followed down first, so that there is a score to beat
_SAME_RAD = math.radians(30.0)


@dataclass(frozen=True)
class Candidate:
    """A pose and how well the scan fits there."""

    pose: FloatArray
    """(3,): x, y in metres, heading in radians."""
    score: float
    """Mean of the field over the scan's points, 0..1."""


def search(
    field: LikelihoodField,
    points_m: FloatArray,
    low_m: FloatArray,
    high_m: FloatArray,
    headings_rad: FloatArray,
    least: float,
    apart_m: float = math.inf,
    ratio: float = 1.0,
) -> list[Candidate]:
    """Best fits of `points_m` (N, 2) with the scan's origin between `low_m` and `high_m` (x, y).

    Best first; no score below `least` or `ratio` times the best; of any two candidates one is
    `apart_m` from the other or turned by 30 degrees.
    """
    turned = _turned(points_m, headings_rad)
    base = field.cells(low_m + turned)  # (headings, points, 2), the origin at the window's corner
    spans = np.ceil((high_m - low_m) / field.cell_m).astype(np.int64) + 1
    top = len(field.levels) - 1
    steps = [np.arange(0, span, 1 << top) for span in spans]
    grid = np.meshgrid(np.arange(len(headings_rad)), *steps, indexing="ij")
    blocks: Ints = np.stack(grid, axis=-1).reshape(-1, 3)
    bounds = _bounds(field, top, base, blocks)
    keep = bounds >= least
    blocks, bounds = blocks[keep], bounds[keep]
    if not len(blocks):
        return []
    first = np.argsort(-bounds)[:_DEPTH_FIRST]
    reached = _depth_first(field, base, blocks[first], bounds[first], spans)
    enough = max(least, ratio * reached)
    for level in range(top - 1, -1, -1):
        blocks = _divided(blocks[bounds >= enough], 1 << level, spans)
        if not len(blocks):
            return []
        bounds = _bounds(field, level, base, blocks)
    order = np.argsort(-bounds)
    order = order[bounds[order] >= max(least, ratio * float(bounds[order[0]]))]
    blocks, scores = blocks[order], bounds[order]
    poses = np.column_stack((low_m + blocks[:, 1:] * field.cell_m, headings_rad[blocks[:, 0]]))
    return _apart(poses, scores, apart_m)


def _turned(points_m: FloatArray, headings_rad: FloatArray) -> FloatArray:
    c, s = np.cos(headings_rad)[:, None], np.sin(headings_rad)[:, None]
    x, y = points_m[:, 0], points_m[:, 1]
    return np.stack((c * x - s * y, s * x + c * y), axis=-1)


def _depth_first(
    field: LikelihoodField, base: Ints, blocks: Ints, bounds: FloatArray, spans: Ints
) -> float:
    # A few blocks down to single shifts: a score that the best one has at least.
    for level in range(len(field.levels) - 2, -1, -1):
        blocks = _divided(blocks, 1 << level, spans)
        bounds = _bounds(field, level, base, blocks)
        kept = np.argsort(-bounds)[:_DEPTH_FIRST]
        blocks, bounds = blocks[kept], bounds[kept]
    return float(bounds.max())


def _divided(blocks: Ints, half: int, spans: Ints) -> Ints:
    corners = np.array([(0, 0, 0), (0, half, 0), (0, 0, half), (0, half, half)])
    parts = (blocks[:, None, :] + corners).reshape(-1, 3)
    return np.asarray(parts[(parts[:, 1] < spans[0]) & (parts[:, 2] < spans[1])])


def _bounds(field: LikelihoodField, level: int, base: Ints, blocks: Ints) -> FloatArray:
    found = np.empty(len(blocks))
    piece = max(1, _LOOKUPS_AT_ONCE // max(1, base.shape[1]))
    for at in range(0, len(blocks), piece):
        part = blocks[at : at + piece]
        cells = base[part[:, 0]] + part[:, None, 1:]
        found[at : at + piece] = field.at(level, cells).mean(axis=1)
    return found


def _apart(poses: FloatArray, scores: FloatArray, apart_m: float) -> list[Candidate]:
    chosen: list[Candidate] = []
    left = np.ones(len(poses), dtype=np.bool_)
    while left.any():
        at = int(np.argmax(left))
        chosen.append(Candidate(poses[at], float(scores[at])))
        near = np.hypot(*(poses[:, :2] - poses[at, :2]).T) < apart_m
        off = np.abs((poses[:, 2] - poses[at, 2] + math.pi) % (2.0 * math.pi) - math.pi)
        left &= ~(near & ((off < _SAME_RAD) | math.isinf(apart_m)))
    return chosen
