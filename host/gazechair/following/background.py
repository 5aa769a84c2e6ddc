"""Background: what stands still, by the map and by the last seconds.

A square of 5 cm is background once returns came from it for more than a second; a beam that passes
through it makes it foreground again. Nothing is learned next to a person who is tracked.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray, FloatArray, Int32Array, IntArray
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid

_CELL_M = 0.05
_CELLS = 256  # along each side of the window round the chair
_RECENTRE_M = 2.5
_STANDS = 12  # scans with a return: background
_MOST = 40
_SHAPE = 3  # the newest scans with a return in a square show what stands there
_BEYOND_M = 0.20  # a beam that ends this far behind a square has passed through it
_PASSED = 3  # returns that one such beam cancels
_FORGET_EVERY = 3  # scans
_BINS = 1440
_KEPT_M = 0.45  # learns nothing this near to a tracked person
_MAP_M = 0.10  # what is this near to an obstacle of the map is background

_Kind = TypeVar("_Kind", bound=np.generic)


class Background:
    """Feed it every scan. `grid`: the map, when poses are in its frame."""

    def __init__(self, grid: OccupancyGrid | None = None) -> None:
        self.has_map = grid is not None
        self._low = np.zeros(2)
        self._counts: NDArray[np.int16] = np.zeros((_CELLS, _CELLS), dtype=np.int16)
        # A square is too coarse for a doorway: the newest return in each quarter, and its scan.
        self._last_m = np.zeros((2 * _CELLS, 2 * _CELLS, 2))
        self._last: Int32Array = np.full((2 * _CELLS, 2 * _CELLS), -_SHAPE, dtype=np.int32)
        self._number = 0
        if grid is not None:
            self._map = _wider(grid.occupied, round(_MAP_M / grid.cell_m))
            self._map_low, self._map_cell_m = grid.low_m, grid.cell_m

    def stands(self, points_m: FloatArray, origin_m: FloatArray) -> BoolArray:
        """Which of a scan's points, (N, 2), are background. `origin_m`: the lidar."""
        if self._number == 0:
            self._low = origin_m - 0.5 * _CELLS * _CELL_M
        self._recentre(origin_m)
        cells = self._cells(points_m)
        found = np.asarray(_wider(self._counts >= _STANDS, 1)[cells[:, 0], cells[:, 1]])
        if self.has_map:
            at = np.floor((points_m - self._map_low) / self._map_cell_m).astype(np.int64)
            inside = ((at >= 0) & (at < self._map.shape)).all(axis=1)
            found[inside] |= self._map[at[inside, 0], at[inside, 1]]
        return found

    def learn(
        self, points_m: FloatArray, origin_m: FloatArray, people_m: Sequence[tuple[float, float]]
    ) -> None:
        """Learn from the same scan, without the surroundings of `people_m`, (x, y) each."""
        self._number += 1
        kept = np.ones(len(points_m), dtype=np.bool_)
        for x, y in people_m:
            kept &= np.hypot(points_m[:, 0] - x, points_m[:, 1] - y) > _KEPT_M
        points_m = points_m[kept]
        cells = np.unique(self._cells(points_m), axis=0)
        at = cells[:, 0], cells[:, 1]
        self._counts[at] = np.minimum(self._counts[at] + 1, _MOST)
        quarters = self._cells(points_m, parts=2)
        at = quarters[:, 0], quarters[:, 1]
        self._last_m[at], self._last[at] = points_m, self._number
        if self._number % _FORGET_EVERY == 0:
            self._forget(points_m, origin_m)

    def standing_m(self, low_m: FloatArray, high_m: FloatArray) -> FloatArray:
        """(N, 2): returns between two corners from what is background by the scans.

        Where no beam goes now, these are the last ones. Where somebody stood who has left, there
        are none, although such a place remains background for some seconds.
        """
        first, end = self._cells(np.stack((low_m, high_m)))
        squares = tuple(slice(a, b + 1) for a, b in zip(first, end, strict=True))
        quarters = tuple(slice(2 * a, 2 * b + 2) for a, b in zip(first, end, strict=True))
        last = self._last[quarters]
        nx, ny = self._counts[squares].shape
        newest = last.reshape(nx, 2, ny, 2).max(axis=(1, 3))
        least = np.where(self._counts[squares] >= _STANDS, newest - _SHAPE, self._number)
        known = (last > 0) & (last > least.repeat(2, 0).repeat(2, 1))
        return np.asarray(self._last_m[quarters][known])

    def _forget(self, points_m: FloatArray, origin_m: FloatArray) -> None:
        """Forget returns in squares that beams have passed through."""
        farthest = np.zeros(_BINS)
        offset = points_m - origin_m
        np.maximum.at(farthest, _bins(offset), np.hypot(offset[:, 0], offset[:, 1]))
        x, y = np.nonzero(self._counts)
        offset = (np.stack((x, y), axis=1) + 0.5) * _CELL_M + self._low - origin_m
        passed = np.hypot(offset[:, 0], offset[:, 1]) < farthest[_bins(offset)] - _BEYOND_M
        x, y = x[passed], y[passed]
        self._counts[x, y] = np.maximum(self._counts[x, y] - _PASSED, 0)
        quarters = self._last.reshape(_CELLS, 2, _CELLS, 2)
        left = quarters[x, :, y].max(axis=(1, 2)) < self._number - _SHAPE
        quarters[x[left], :, y[left]] = -_SHAPE

    def _cells(self, points_m: FloatArray, parts: int = 1) -> IntArray:
        """Squares of points; outside the window the border's, which is beyond every track."""
        cells = np.floor((points_m - self._low) * (parts / _CELL_M)).astype(np.int64)
        return np.asarray(np.clip(cells, 0, parts * _CELLS - 1))

    def _recentre(self, origin_m: FloatArray) -> None:
        off = np.round((origin_m - self._low) / _CELL_M - 0.5 * _CELLS).astype(np.int64)
        if np.abs(off).max() * _CELL_M < _RECENTRE_M:
            return
        self._counts = _shifted(self._counts, off, 0)
        self._last_m = _shifted(self._last_m, 2 * off, 0.0)
        self._last = _shifted(self._last, 2 * off, -_SHAPE)
        self._low = self._low + off * _CELL_M


def _shifted(squares: NDArray[_Kind], by: IntArray, empty: float) -> NDArray[_Kind]:
    """The squares as seen from a window that lies `by` squares farther on."""
    found = np.full_like(squares, empty)
    to, begin = np.maximum(-by, 0), np.maximum(by, 0)
    size = np.maximum(len(squares) - np.abs(by), 0)
    found[to[0] : to[0] + size[0], to[1] : to[1] + size[1]] = squares[
        begin[0] : begin[0] + size[0], begin[1] : begin[1] + size[1]
    ]
    return found


def _bins(offset: FloatArray) -> IntArray:
    bearings = np.arctan2(offset[:, 1], offset[:, 0]) / (2.0 * np.pi)
    return np.asarray((bearings * _BINS).astype(np.int64) % _BINS)


def _wider(cells: BoolArray, by: int) -> BoolArray:
    """The cells, grown by `by` cells on every side, as squares."""
    found = cells.copy()
    for axis in (0, 1):
        grown = found.copy()
        for step in range(1, by + 1):
            ahead = [slice(None), slice(None)]
            back = [slice(None), slice(None)]
            ahead[axis], back[axis] = slice(step, None), slice(None, -step)
            grown[tuple(ahead)] |= found[tuple(back)]
            grown[tuple(back)] |= found[tuple(ahead)]
        found = grown
    return found
