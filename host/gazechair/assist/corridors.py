"""Straight corridors as wide as the chair: how far each is free, at many offsets."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import FloatArray

Narrow = NDArray[np.float32]

CELL_M = 0.01
FARTHEST_M = 4.5


class Corridors:
    """Corridors between the points round the chair; directions are relative to its heading."""

    def __init__(self, points_m: FloatArray, directions_rad: FloatArray, aside_m: float) -> None:
        """`points_m`: (N, 2). `aside_m`: the largest offset plus half the widest corridor."""
        c, s = np.cos(directions_rad), np.sin(directions_rad)
        points = points_m.T.astype(np.float32)
        self._low_m = -aside_m
        self._count = math.ceil(2.0 * aside_m / CELL_M)
        ahead = np.stack((c, s), axis=1).astype(np.float32) @ points
        aside = (np.stack((-s, c), axis=1) / CELL_M).astype(np.float32) @ points
        aside -= self._low_m / CELL_M
        cells = np.floor(aside, out=aside).astype(np.int32)
        kept = cells.view(np.uint32) < self._count  # as unsigned, a negative cell is too large
        kept &= ahead > 0.0
        at = np.flatnonzero(kept)
        rows = at // max(1, points.shape[1])
        nearest = np.full((len(directions_rad), self._count), FARTHEST_M, dtype=np.float32)
        index = rows * self._count + cells.ravel().take(at)
        np.minimum.at(nearest.reshape(-1), index, ahead.ravel().take(at))
        self._nearest = nearest

    def free_m(self, offsets_m: FloatArray, half_m: float) -> FloatArray:
        """(directions, offsets): metres from the axle to the first point within `half_m` of a line.

        Offsets of the lines are to the left of the one through the axle in that direction.
        """
        width = round(2.0 * half_m / CELL_M)
        least = _sliding_minimum(self._nearest, width)
        first = np.round((offsets_m - half_m - self._low_m) / CELL_M).astype(np.int64)
        return np.asarray(least[:, first], dtype=np.float64)


def _sliding_minimum(values: Narrow, width: int) -> Narrow:
    # The window doubles with each pass.
    least, have = values, 1
    while have < width:
        step = min(have, width - have)
        least = np.minimum(least[:, :-step], least[:, step:])
        have += step
    return least
