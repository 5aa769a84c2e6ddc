"""Scores how well looks fit a known map at a pose: what is explained, and what contradicts it.

A beam ends at a known surface (explained), before one (a person, or something new), or has passed
through one (a contradiction: walls are opaque; an opened door or moved furniture is a small part of
a look).

Static surfaces of several looks are compared by length: surfaces that the map has, too (agreed),
and surfaces of the map where the looks found free floor (contradicted).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.poses import from_frame, to_frame
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, marked
from gazechair.sensing.mapping.locating.recent_looks import CELL_M, Settled
from gazechair.sensing.mapping.matching.faces import faces_of
from gazechair.sensing.mapping.matching.likelihood_field import LikelihoodField
from gazechair.sensing.mapping.matching.ndt import NdtGrid

_COARSE_M, _COARSE_SIGMA_M, _LEVELS = 0.10, 0.12, 5
_FINE_M, _NEAR_M = 0.05, 0.10  # a beam that ends this near a known surface is explained
_BEAMS = 240
_STEP_M = 0.05
_FURNITURE_M = 0.5  # from the middle of a piece to the floor beside it
_SHORT_M = 0.25  # the last part of a beam contradicts nothing
_CLOSE_CELL_M, _CLOSE_M = 0.025, 0.06  # a surface this close to a known one is agreed
_PART_M = 0.05
# Straight: within a band, in one of these directions, and the next cell at most so many on: people
# who stand in a row are no surface.
_GAP = 3
_BAND_M, _DIRECTIONS_RAD = 0.1, np.radians(np.arange(0.0, 180.0, 5.0))
_NEAR = math.exp(-0.5)  # of a field whose sigma is _NEAR_M, or _CLOSE_M


@dataclass(frozen=True)
class Look:
    """What the lidars saw at one time: ends and beginnings of the beams, both (N, 2)."""

    points_m: FloatArray
    origins_m: FloatArray

    def moved(self, pose: FloatArray) -> Look:
        """The look transformed into the frame in which `pose` is given."""
        return Look(to_frame(self.points_m, pose), to_frame(self.origins_m, pose))


@dataclass(frozen=True)
class Evidence:
    """Shares of the beams, 0..1."""

    explained: float
    through: float
    crossed: float = 0.0
    """The share, by length, that beams pass through, of the map's surfaces that they reach: a
    mirror close by fills a third of a look, but counts by its length only."""


@dataclass(frozen=True)
class Agreement:
    """Agreement of the static surfaces around the chair with a map, at a pose."""

    agreed: BoolArray
    """Which of the settled surfaces' cells the map has, too."""
    contradicted_m: float
    """Length of the map's surfaces where free floor was seen."""

    @property
    def agreed_m(self) -> float:
        """Length of the agreed surfaces."""
        return CELL_M * int(self.agreed.sum())

    @property
    def value_m(self) -> float:
        """For comparing poses: more is better."""
        return self.agreed_m - self.contradicted_m


def together(looks: list[Look]) -> Look:
    """Several looks as one."""
    return Look(
        np.concatenate([look.points_m for look in looks]),
        np.concatenate([look.origins_m for look in looks]),
    )


class MapMatch:
    """A map prepared for matching. ValueError when nothing in it is occupied."""

    def __init__(self, grid: OccupancyGrid) -> None:
        known = grid.occupied_m()
        if not len(known):
            raise ValueError("nothing in the map is occupied")
        self._grid = grid
        self.cell_m = grid.cell_m
        self._free = grid.free
        self._fine = LikelihoodField(known, _FINE_M, _NEAR_M)
        self._solid = LikelihoodField(known, _FINE_M, _FINE_M / 4.0)
        self._close = LikelihoodField(known, _CLOSE_CELL_M, _CLOSE_M)
        self._surfaces_m = (np.unique(np.floor(known / CELL_M), axis=0) + 0.5) * CELL_M
        self.coarse = LikelihoodField(known, _COARSE_M, _COARSE_SIGMA_M, _LEVELS)
        faces = faces_of(grid.occupied, self._free, grid.cell_m)
        parts = _parts(grid.cell_m)
        self.ndt = NdtGrid(
            (known[:, None] + parts).reshape(-1, 2), faces.repeat(len(parts), axis=0)
        )

    def near_free_floor(self, pose: FloatArray) -> bool:
        """Whether the map has free floor around the pose: furniture there may be gone."""
        around = np.array((-_FURNITURE_M, _FURNITURE_M))[:, None] + pose[:2]
        cells = np.floor((around - self._grid.low_m) / self._grid.cell_m).astype(int)
        (i0, j0), (i1, j1) = np.maximum(cells, 0)
        return bool(self._free[i0 : i1 + 1, j0 : j1 + 1].any())

    def evidence(self, look: Look, pose: FloatArray) -> Evidence:
        """Evidence for and against the look having been taken at `pose`."""
        every = max(1, len(look.points_m) // _BEAMS)
        placed = Look(look.points_m[::every], look.origins_m[::every]).moved(pose)
        ends, starts = placed.points_m, placed.origins_m
        explained = self._fine.at(0, self._fine.cells(ends)) >= _NEAR
        along = ends - starts
        length = np.hypot(*along.T)
        steps = np.maximum(0, np.floor((length - _SHORT_M) / _STEP_M)).astype(np.int64)
        beam = np.repeat(np.arange(len(ends)), steps)
        share = _STEP_M * (np.arange(len(beam)) - np.repeat(np.cumsum(steps) - steps, steps))
        at = starts[beam] + along[beam] * (share / length[beam])[:, None]
        solid = self._solid.at(0, self._solid.cells(at)) == 1.0
        # A beam that grazes a wall passes its cells: explained beams contradict nothing there.
        solid &= ~explained[beam]
        through, first = np.unique(beam[solid], return_index=True)
        passed = self._count(at[solid][first])
        share = passed / max(1, passed + self._count(ends[explained]))
        return Evidence(float(explained.mean()), len(through) / len(ends), share)

    def _count(self, points_m: FloatArray) -> int:
        """Number of coarse cells with points, as beams that end far away are far apart."""
        return len(np.unique(self.coarse.cells(points_m), axis=0))

    def agreement(self, settled: Settled, frame: FloatArray) -> Agreement:
        """Agreement with the map if the frame of `settled` is at the pose `frame` in it."""
        placed = to_frame(settled.surfaces_m, frame)
        agreed = np.asarray(self._close.at(0, self._close.cells(placed)) >= _NEAR)
        seen_free = settled.is_free(from_frame(self._surfaces_m, frame))
        return Agreement(agreed, CELL_M * int(seen_free.sum()))

    def new_straight_m(self, settled: Settled, agreement: Agreement, frame: FloatArray) -> float:
        """Length of the longest straight surface that stands where the map has free floor."""
        new = to_frame(settled.surfaces_m[~agreement.agreed], frame)
        cells = np.floor((new - self._grid.low_m) / self._grid.cell_m).astype(np.int64)
        new = new[marked(self._free, cells)]
        return max((_straight_m(new, one) for one in _DIRECTIONS_RAD), default=0.0)


def _straight_m(points_m: FloatArray, direction_rad: float) -> float:
    """Length of the longest run in one band along a direction, in cells; bands overlap by half."""
    if not len(points_m):
        return 0.0
    c, s = math.cos(direction_rad), math.sin(direction_rad)
    along = np.floor(points_m @ (c, s) / CELL_M).astype(np.int64)
    across = points_m @ (-s, c) / _BAND_M
    longest = 0
    for shift in (0.0, 0.5):
        band = np.floor(across + shift).astype(np.int64)
        each = np.unique(np.stack((band, along), axis=1), axis=0)  # in order
        apart = np.diff(each, axis=0)
        ends = np.flatnonzero((apart[:, 0] > 0) | (apart[:, 1] > _GAP))
        runs = np.diff(np.concatenate(([-1], ends, [len(each) - 1])))
        longest = max(longest, int(runs.max()))
    return CELL_M * longest


def _parts(cell_m: float) -> FloatArray:
    """Centres (N, 2) of a cell's parts, relative to its own: large cells give too few points."""
    count = math.ceil(cell_m / _PART_M)
    side = ((np.arange(count) + 0.5) / count - 0.5) * cell_m
    return np.asarray(np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2))
