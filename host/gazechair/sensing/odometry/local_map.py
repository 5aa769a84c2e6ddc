"""The surfaces around the chair that odometry remembers, as point moments of overlapping cells.

A cell keeps the moments of all points within its own square and the eight around it, so that a
surface is found by one index. Four layers by the side a surface is seen from keep the two
faces of a thin wall apart. A cell counts once it was seen at two moments: people who walk by leave
nothing. What is farther away than the window is forgotten.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray, IntArray

SIZE = 512  # cells along each side of the window
_STRIDE = 64  # cells by which the window moves
_FULL = 20  # points at which a cell is frozen, so that it cannot drift
_APART_S = 0.25
_BEGINS_S = 0.25  # surfaces seen during this time count at once
_LAYERS = 4


class LocalMap:
    """Moments of the surfaces within some 18 m; coordinates of the odometry's frame, metres."""

    def __init__(self, cell_m: float) -> None:
        self._cell_m = cell_m
        self._moments = np.zeros((_LAYERS * SIZE * SIZE, 6), dtype=np.float32)
        self._seen = np.zeros(_LAYERS * SIZE * SIZE, dtype=np.uint8)  # moments of time, up to 2
        self._last_s = np.full(_LAYERS * SIZE * SIZE, -np.inf, dtype=np.float32)
        # When a cell was begun, unless before anything was forgotten.
        self._first_s = np.full(_LAYERS * SIZE * SIZE, -np.inf, dtype=np.float32)
        self._since_s = -math.inf  # what was begun before is forgotten
        self._low = np.array((-SIZE // 2, -SIZE // 2))
        self._start_s: float | None = None

    def clear(self) -> None:
        """Forget everything."""
        self.__init__(self._cell_m)  # type: ignore[misc]

    def begin_anew(self, now_s: float) -> None:
        """Forget what was seen until now; no array is written, so it costs nothing."""
        if self._start_s is not None:
            self._since_s = now_s - self._start_s

    def follow(self, x_m: float, y_m: float) -> None:
        """Keep the window around the chair."""
        for axis, at_m in enumerate((x_m, y_m)):
            off = int(np.floor(at_m / self._cell_m)) - (int(self._low[axis]) + SIZE // 2)
            while abs(off) > _STRIDE:
                step = _STRIDE if off > 0 else -_STRIDE
                first = self._low[axis] + (SIZE if step > 0 else step)
                self._low[axis] += step
                off -= step
                self._wipe(axis, first % SIZE)

    def _wipe(self, axis: int, first: int) -> None:
        # Strides divide the window, so that no strip wraps.
        strip = slice(first, first + _STRIDE)
        where = (slice(None), strip) if axis == 0 else (slice(None), slice(None), strip)
        shape = (_LAYERS, SIZE, SIZE)
        self._moments.reshape(*shape, 6)[where] = 0.0
        self._seen.reshape(shape)[where] = 0
        self._last_s.reshape(shape)[where] = -np.inf
        self._first_s.reshape(shape)[where] = -np.inf

    def look_up(self, points_m: FloatArray, layers: IntArray) -> tuple[FloatArray, FloatArray]:
        """(N, 6) moments of each point's cell, and the cells' centres; zeros: nothing known."""
        column = np.floor(points_m * (1.0 / self._cell_m)).astype(np.int64)
        index = (layers * SIZE + column[:, 0] % SIZE) * SIZE + column[:, 1] % SIZE
        moments = self._moments[index].astype(np.float64)
        moments[(self._seen[index] < 2) | (self._first_s[index] < self._since_s)] = 0.0
        return moments, np.asarray((column + 0.5) * self._cell_m, dtype=np.float64)

    def insert(self, points_m: FloatArray, layers: IntArray, now_s: float) -> None:
        """Add points, each to the nine cells whose squares it is in or beside."""
        column = np.floor(points_m * (1.0 / self._cell_m)).astype(np.int64)
        if self._start_s is None:
            self._start_s = now_s
        relative_s = np.float32(now_s - self._start_s)
        around = _AROUND[None, :, :] + column[:, None, :]
        offset = (points_m[:, None, :] - (around + 0.5) * self._cell_m).reshape(-1, 2)
        index = (layers[:, None] * SIZE + around[..., 0] % SIZE) * SIZE + around[..., 1] % SIZE
        index = index.reshape(-1)
        forgotten = index[self._first_s[index] < self._since_s]
        self._moments[forgotten] = 0.0
        self._seen[forgotten] = 0
        self._last_s[forgotten] = -np.inf
        self._first_s[forgotten] = relative_s
        free = self._moments[index, 0] < _FULL
        index, offset = index[free], offset[free]
        x, y = offset[:, 0], offset[:, 1]
        rows = np.stack((np.ones_like(x), x, y, x * x, x * y, y * y), axis=1)
        np.add.at(self._moments, index, rows.astype(np.float32))
        cells = np.unique(index)
        later = cells[relative_s - self._last_s[cells] >= _APART_S]
        begins = relative_s - max(0.0, self._since_s) < _BEGINS_S
        self._seen[later] = np.minimum(self._seen[later] + (2 if begins else 1), 2)
        self._last_s[later] = relative_s


_AROUND = np.stack(np.meshgrid((-1, 0, 1), (-1, 0, 1)), axis=2).reshape(-1, 2)


def layers_of(normals: FloatArray) -> IntArray:
    """The layer of surfaces that look towards `normals`."""
    flat = np.abs(normals[:, 0]) >= np.abs(normals[:, 1])
    return np.where(flat, (normals[:, 0] > 0.0).astype(np.int64), 2 + (normals[:, 1] > 0.0))
