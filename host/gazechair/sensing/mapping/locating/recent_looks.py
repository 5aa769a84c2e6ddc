"""Finds what is static in recent looks: surfaces seen repeatedly, and floor seen free.

People move, walls do not: what one look saw and another saw through is left out. The rest is
counted in cells, so that a person close by, who fills half of a look, counts by their size only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.sensing.mapping.building.occupancy_grid import marked

CELL_M = 0.05
_LOOKS = 20  # kept
_FARTHEST_M = 12.0
_BEAMS = 200  # beams of a look that clear cells, at most
_STEP = 0.7  # cells, along a beam
_SHORT_M, _CLEARS = 0.06, 0.85  # a beam clears up to this far before its end, at most this share:
# beams that graze a wall come near it at their ends
_MIDDLE = 0.4  # in cells, from a cell's centre: beams that cut a corner are ignored
_TWICE = 2  # least number of looks that saw it
_STAYS = 0.5  # share of the looks at a cell that end there: it is static
_BLOCKS = 0.2  # from this share on, nothing near it counts as free, even if it is not static
_NEAR = 2  # cells
_STOOD_M = 0.25  # around the drive axle's middle the floor is free: the chair stood there
_SHIFT = 1 << 20  # of a cell's index, to put two into one number


@dataclass(frozen=True)
class Settled:
    """Static surfaces and free floor, in odometry's frame."""

    surfaces_m: FloatArray
    """(N, 2): cells of CELL_M with something static."""
    _free: BoolArray
    _low: IntArray

    def is_free(self, places_m: FloatArray) -> BoolArray:
        """(N,): whether beams went through there, and nothing was seen near it."""
        cells = np.floor(places_m / CELL_M).astype(np.int64) - self._low
        return marked(self._free, cells)

    def mirrored(self) -> Settled:
        """Its mirror image across the x axis of odometry's frame."""
        low = np.array((self._low[0], -self._low[1] - self._free.shape[1]))
        return Settled(self.surfaces_m * (1.0, -1.0), self._free[:, ::-1], low)


class RecentLooks:
    """Feed it looks, in odometry's frame."""

    def __init__(self) -> None:
        self._looks: list[
            tuple[IntArray, IntArray]
        ] = []  # cells where beams ended, and went through

    def add(self, starts_m: FloatArray, ends_m: FloatArray, stood_m: FloatArray) -> None:
        """A look's beams, (N, 2) each, and where the chair stood, (2,) or more."""
        along = ends_m - starts_m
        length = np.hypot(*along.T)
        near = length < _FARTHEST_M
        ended = np.unique(_numbers(ends_m[near] / CELL_M))
        every = slice(None, None, max(1, int(near.sum()) // _BEAMS))
        starts, along, length = (one[near][every] for one in (starts_m, along, length))
        clear = np.maximum(0.0, np.minimum(length - _SHORT_M, _CLEARS * length))
        steps = np.floor(clear / (_STEP * CELL_M)).astype(np.int64)
        beam = np.repeat(np.arange(len(length)), steps)
        nth = np.arange(len(beam)) - np.repeat(np.cumsum(steps) - steps, steps)
        share = _STEP * CELL_M * nth / length[beam]
        at = (starts[beam] + along[beam] * share[:, None]) / CELL_M
        middle = (np.abs(at - np.floor(at) - 0.5) < _MIDDLE).all(axis=1)
        through = np.unique(_numbers(np.concatenate((at[middle], _stood(stood_m)))))
        through = np.setdiff1d(through, ended, assume_unique=True)
        self._looks = [*self._looks, (ended, through)][-_LOOKS:]

    def forget(self) -> None:
        """Discard all looks."""
        self._looks = []

    def settled(self, newest: int = _LOOKS) -> Settled | None:
        """What is static in the newest looks; None: too few looks, or nothing is static."""
        looks = self._looks[-newest:]
        if len(looks) < _TWICE:
            return None
        ended, ends = _counted([one for one, _ in looks])
        through, passes = _counted([one for _, one in looks])
        at = np.searchsorted(through, ended) % len(through)
        share = ends / (ends + np.where(through[at] == ended, passes[at], 0))
        stays = (ends >= _TWICE) & (share >= _STAYS)
        passed = _cells(through[passes >= _TWICE])
        if not stays.any() or not len(passed):
            return None
        low = passed.min(axis=0) - 2 * _NEAR
        free = np.zeros(tuple((passed.max(axis=0) + 2 * _NEAR + 1 - low).tolist()), dtype=bool)
        free[tuple((passed - low).T)] = True
        blocks = _cells(ended[share >= _BLOCKS]) - low
        blocks = blocks[((blocks >= _NEAR) & (blocks < np.array(free.shape) - _NEAR)).all(axis=1)]
        for i in range(-_NEAR, _NEAR + 1):
            for j in range(-_NEAR, _NEAR + 1):
                free[blocks[:, 0] + i, blocks[:, 1] + j] = False
        surfaces = np.asarray((_cells(ended[stays]) + 0.5) * CELL_M, dtype=np.float64)
        return Settled(surfaces, free, low)


def _stood(at_m: FloatArray) -> FloatArray:
    """Cells around a place."""
    side = np.arange(-_STOOD_M, _STOOD_M, CELL_M)
    disc = np.stack([one.ravel() for one in np.meshgrid(side, side)], axis=1)
    return np.asarray((at_m[:2] + disc[np.hypot(*disc.T) < _STOOD_M]) / CELL_M)


def _counted(looks: list[IntArray]) -> tuple[IntArray, IntArray]:
    found, counts = np.unique(np.concatenate(looks), return_counts=True)
    return found, counts


def _numbers(places: FloatArray) -> IntArray:
    """One number for each cell, of places in cells."""
    cells = np.floor(places).astype(np.int64)
    return np.asarray((cells[:, 0] + _SHIFT) * (2 * _SHIFT) + cells[:, 1] + _SHIFT)


def _cells(numbers: IntArray) -> IntArray:
    return np.stack((numbers // (2 * _SHIFT) - _SHIFT, numbers % (2 * _SHIFT) - _SHIFT), axis=1)
