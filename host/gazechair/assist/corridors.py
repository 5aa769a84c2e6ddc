"""Straight corridors as wide as the chair: how far each is free, at many offsets."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.footprint import FloatArray

CELL_M = 0.01
FARTHEST_M = 4.5


class Corridors:
    """Of the points round the chair; directions are relative to its heading."""

    def __init__(self, points_m: FloatArray, directions_rad: FloatArray, aside_m: float) -> None:
        """`aside_m`: the farthest offset that is asked for, with half the widest corridor."""
        c, s = np.cos(directions_rad)[:, None], np.sin(directions_rad)[:, None]
        x, y = points_m[:, 0], points_m[:, 1]
        ahead = c * x + s * y
        aside = c * y - s * x
        self._low_m = -aside_m
        self._count = math.ceil(2.0 * aside_m / CELL_M)
        cells = np.floor((aside - self._low_m) * (1.0 / CELL_M)).astype(np.int64)
        kept = (ahead > 0.0) & (ahead < FARTHEST_M) & (cells >= 0) & (cells < self._count)
        rows = np.broadcast_to(np.arange(len(directions_rad))[:, None], cells.shape)
        nearest = np.full((len(directions_rad), self._count), FARTHEST_M)
        np.minimum.at(nearest, (rows[kept], cells[kept]), ahead[kept])
        self._nearest = nearest

    def free_m(self, offsets_m: FloatArray, half_m: float) -> FloatArray:
        """(directions, offsets): how far from the axle on nothing is within `half_m` of the line.

        Offsets are to the left of the axle's own line in that direction.
        """
        width = round(2.0 * half_m / CELL_M)
        least = _sliding_minimum(self._nearest, width)
        first = np.round((offsets_m - half_m - self._low_m) / CELL_M).astype(np.int64)
        return np.asarray(least[:, first])


def _sliding_minimum(values: FloatArray, width: int) -> FloatArray:
    # Windows of twice the width each time.
    least, have = values, 1
    while have < width:
        step = min(have, width - have)
        least = np.minimum(least[:, :-step], least[:, step:])
        have += step
    return least
