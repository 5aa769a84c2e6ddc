"""Likelihood field: how likely a lidar sees a point at each place; scans are scored against it.

A cell's value falls as a Gaussian of the distance to the nearest known point. The field is kept at
several levels: at level k a cell holds the maximum over the 2**k by 2**k cells that begin there, so
that one lookup bounds a whole block of shifts (Olson, Real-time correlative scan matching, 2009).
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import Float32Array, FloatArray, IntArray

_REACH_SIGMAS = 3.0


class LikelihoodField:
    """Values 0..1 around the known points `known_m` (N, 2), in cells of `cell_m`."""

    def __init__(self, known_m: FloatArray, cell_m: float, sigma_m: float, levels: int = 1):
        self.cell_m = cell_m
        reach = math.ceil(_REACH_SIGMAS * sigma_m / cell_m)
        cells = np.floor(known_m / cell_m).astype(np.int64)
        low, high = cells.min(axis=0) - reach - 1, cells.max(axis=0) + reach + 2
        self.low_m: FloatArray = np.asarray(low * cell_m, dtype=np.float64)
        cells -= low
        values = np.zeros(tuple((high - low).tolist()), dtype=np.float32)
        values[cells[:, 0], cells[:, 1]] = 1.0
        self.levels = [_blurred(values, reach, cell_m / sigma_m)]
        for level in range(levels - 1):
            self.levels.append(_maximum(self.levels[-1], 1 << level))
        self._bordered = [np.pad(values, 1) for values in self.levels]

    @property
    def high_m(self) -> FloatArray:
        """The corner opposite to `low_m`."""
        return np.asarray(self.low_m + np.array(self.levels[0].shape) * self.cell_m)

    def cells(self, points_m: FloatArray) -> IntArray:
        """The cells (..., 2) of points (..., 2); may lie outside."""
        return np.floor((points_m - self.low_m) / self.cell_m).astype(np.int64)

    def at(self, level: int, cells: IntArray) -> Float32Array:
        """Values of `level` in cells (..., 2); 0 where neither the cell nor its block reaches."""
        values = self._bordered[level]
        nx, ny = values.shape
        first = 1 << level  # a level's array begins this many cells earlier, its border included
        i = np.clip(cells[..., 0] + first, 0, nx - 1)
        j = np.clip(cells[..., 1] + first, 0, ny - 1)
        return np.asarray(values.ravel().take(i * ny + j))

    def part(self, level: int, low: IntArray, high: IntArray) -> Float32Array:
        """Values of `level`, as `at` gives them, in all cells from `low` to `high`, (2,) each."""
        values = self.levels[level]
        first = low + (1 << level) - 1
        found = np.zeros(tuple((high - low + 1).tolist()), dtype=np.float32)
        begin = np.maximum(first, 0)
        end = np.minimum(first + found.shape, values.shape)
        if (begin < end).all():
            (i0, j0), (i1, j1) = begin - first, end - first
            found[i0:i1, j0:j1] = values[begin[0] : end[0], begin[1] : end[1]]
        return found


def _blurred(values: Float32Array, reach: int, step: float) -> Float32Array:
    # A Gaussian of the distance to the nearest: maxima of products, one axis after the other.
    for axis in (0, 1):
        found = values.copy()
        for k in range(1, reach + 1):
            near = values * np.float32(math.exp(-0.5 * (k * step) ** 2))
            ahead, behind = [slice(None)] * 2, [slice(None)] * 2
            ahead[axis], behind[axis] = slice(k, None), slice(None, -k)
            a, b = tuple(ahead), tuple(behind)
            np.maximum(found[a], near[b], out=found[a])
            np.maximum(found[b], near[a], out=found[b])
        values = found
    return values


def _maximum(values: Float32Array, step: int) -> Float32Array:
    # The level above begins `step` cells earlier: its first blocks still reach into the field.
    wide = np.pad(values, step)
    found = np.maximum(wide[:-step], wide[step:])
    return np.maximum(found[:, :-step], found[:, step:])
