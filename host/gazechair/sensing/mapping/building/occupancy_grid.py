"""Occupancy grid: number of key scans in which a beam ended in each cell, or passed it.

A cell is occupied when beams ended there repeatedly and few passed: people who walked by leave no
trace, and a thin wall is kept. Where the chair itself stood, the floor is free.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.base.poses import to_frame
from gazechair.sensing.mapping.building.mapper import KeyScan

Counts = NDArray[np.uint16]
Beams = tuple[FloatArray, FloatArray]  # where each began and ended

CELL_M = 0.025
_FARTHEST_M = 12.0  # a hit farther away is too uncertain for a cell
_BEAMS = 720  # beams of a key scan that clear cells, at most
_SHORT_M = 0.06  # a beam clears nothing this close to its end
_MIDDLE = 0.35  # in cells, from a cell's centre
_LEAST_HITS = 2
_OCCUPIED_SHARE = 0.25
_BORDER = 4  # cells
_SAME_CELL = 1e-5  # of its size: exports of ROS round it
_STOOD_M = 0.25  # around the drive axle's middle: no beam of a lidar in front passes there


@dataclass(frozen=True)
class OccupancyGrid:
    """Counts (nx, ny) of key scans; cell (0, 0) begins at `low_m` (x, y)."""

    cell_m: float
    low_m: FloatArray
    hits: Counts
    passes: Counts

    @property
    def occupied(self) -> BoolArray:
        """(nx, ny): occupied cells."""
        share = self.hits >= _OCCUPIED_SHARE * (self.hits.astype(np.float64) + self.passes)
        return np.asarray(share & (self.hits >= _LEAST_HITS))

    @property
    def free(self) -> BoolArray:
        """(nx, ny): cells that a beam passed or the chair stood on, not occupied; else unknown."""
        return np.asarray((self.passes > 0) & ~self.occupied)

    def lies_as(self, other: OccupancyGrid) -> bool:
        """Whether the cells of both grids coincide."""
        shapes = self.hits.shape == other.hits.shape and self.cell_m == other.cell_m
        return shapes and np.array_equal(self.low_m, other.low_m)

    def same_as(self, other: OccupancyGrid) -> bool:
        """Whether both grids are identical."""
        if self is other:
            return True
        counts = np.array_equal(self.hits, other.hits) and np.array_equal(self.passes, other.passes)
        return counts and self.lies_as(other)

    def is_copy_of(self, other: OccupancyGrid) -> bool:
        """Whether the same floor is free in both, as in a grid and its export (see ros_map)."""
        cells_m = self.cell_m, other.cell_m
        if self.hits.shape != other.hits.shape or not math.isclose(*cells_m, rel_tol=_SAME_CELL):
            return False
        near = np.allclose(self.low_m, other.low_m, atol=0.1 * self.cell_m)
        return near and np.array_equal(self.free, other.free)

    def occupied_m(self) -> FloatArray:
        """Centres (N, 2) of the occupied cells."""
        return np.asarray((np.argwhere(self.occupied) + 0.5) * self.cell_m + self.low_m)


def marked(mask: BoolArray, cells: IntArray) -> BoolArray:
    """(N,): which of `cells` (N, 2) lie within the mask, and are set in it."""
    inside = np.asarray(((cells >= 0) & (cells < mask.shape)).all(axis=1))
    i, j = np.where(inside[:, None], cells, 0).T
    return np.asarray(inside & mask[i, j])


def box_m(keys: Iterable[KeyScan]) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest (x, y) of what a grid of these key scans shows. Needs at least one."""
    return _box_m((_in_map(key), key.pose[:2]) for key in keys)


def _box_m(placed: Iterable[tuple[Beams, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """The same, of beams in the map and where the chair stood."""
    corners = []
    for beams, stood in placed:
        parts = np.concatenate((*beams, (stood - _STOOD_M, stood + _STOOD_M)))
        corners += [parts.min(axis=0), parts.max(axis=0)]
    return np.min(corners, axis=0), np.max(corners, axis=0)


def occupancy_of(keys: Iterable[KeyScan], cell_m: float = CELL_M) -> OccupancyGrid:
    """The grid of key scans at the poses they have now. ValueError without any point."""
    keys = list(keys)
    scans = [_in_map(key) for key in keys]
    if not any(len(end) for _, end in scans):
        raise ValueError("no lidar points to make a map of")
    stood = np.array([key.pose[:2] for key in keys])
    low_m, high_m = _box_m(zip(scans, stood, strict=True))
    low = np.floor(low_m / cell_m).astype(np.int64) - _BORDER
    shape = np.floor(high_m / cell_m).astype(np.int64) + _BORDER + 1 - low
    hits, passes = (np.zeros(int(shape.prod()), dtype=np.uint16) for _ in range(2))
    depth = int(shape[1])
    side = np.arange(-_STOOD_M, _STOOD_M, cell_m)
    disc = np.stack([one.ravel() for one in np.meshgrid(side, side)], axis=1)
    disc = disc[np.hypot(*disc.T) < _STOOD_M]
    for (start, end), place in zip(scans, stood, strict=True):
        cells = np.floor(end / cell_m).astype(np.int64) - low
        hit = np.unique(cells[:, 0] * depth + cells[:, 1])
        hits[hit] += 1
        here = np.floor((place + disc) / cell_m).astype(np.int64) - low
        beams = _passed(start / cell_m - low, end / cell_m - low, depth, cell_m)
        passed = np.unique(np.concatenate((beams, here[:, 0] * depth + here[:, 1])))
        passes[np.setdiff1d(passed, hit, assume_unique=True)] += 1
    grid = tuple(shape.tolist())
    corner_m = np.asarray(low * cell_m, dtype=np.float64)
    return OccupancyGrid(cell_m, corner_m, hits.reshape(grid), passes.reshape(grid))


def _in_map(key: KeyScan) -> Beams:
    """Where each beam began and ended."""
    near = np.hypot(*(key.points_m - key.origins_m).T) < _FARTHEST_M
    return to_frame(key.origins_m[near], key.pose), to_frame(key.points_m[near], key.pose)


def _passed(start: FloatArray, end: FloatArray, depth: int, cell_m: float) -> IntArray:
    """Indices of the cells whose middle a beam passes; start and end in cells."""
    every = max(1, len(start) // _BEAMS)
    _, at = along_beams(start[::every], end[::every], _SHORT_M / cell_m)
    found = through_middle(at)
    return np.asarray(found[:, 0] * depth + found[:, 1])


def along_beams(start: FloatArray, end: FloatArray, short: float) -> tuple[IntArray, FloatArray]:
    """Half a cell apart, places (M, 2) on the beams, and the beam (M,) of each; all in cells.

    They end `short` before the beam does.
    """
    length = np.hypot(*(end - start).T)
    steps = np.maximum(0, np.floor(2.0 * (length - short))).astype(np.int64)
    beam = np.repeat(np.arange(len(start)), steps)
    along = 0.5 * (np.arange(len(beam)) - np.repeat(np.cumsum(steps) - steps, steps))
    at = start[beam] + (end - start)[beam] * (along / length[beam])[:, None]
    return beam, at


def through_middle(at: FloatArray) -> IntArray:
    """Cells (K, 2) of the places near a cell's middle: beams that only cut a corner are ignored."""
    cells = np.floor(at)
    middle = (np.abs(at - cells - 0.5) < _MIDDLE).all(axis=1)
    return np.asarray(cells[middle].astype(np.int64))
