"""How far the chair may travel while it turns: a table look-up for each point around it.

A chair that drives and turns at once follows no known curve: its two axes start, stop and brake
independently. So the check covers all curves: while the chair turns by up to some angle and travels
by up to some length, either first or both at once, which places may its footprint reach? The
tables hold, for each cell of the floor, the shortest travel that reaches it (see gazelink.arcs for
the rows). They are computed once from the footprint; a view then costs a look-up per point.

At a heading of t the drive axle may be anywhere in the sector of that travel with directions
between 0 and t, so the reachable area is the footprint grown by that sector. Half planes of a few
normals bound both, never too small. The footprint also grows by the error of a cell and of an angle
step, which is taken from the margin as far as that suffices. So a cell's value is never too long
for contact with the bare outline, and at most a cell too long for contact with its margin.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from gazechair.base.footprint import Footprint, Margins, distance_m, inside
from gazelink import arcs, codes

_MOST_M = arcs.FAR * arcs.UNIT_MM / 1000.0
_STEP_RAD = math.radians(1.0)
_BOTH_STEP_RAD = math.radians(4.0)
# Cell size and extent beyond the outline, the coarsest first; a point beyond all limits no arc.
_GRIDS_M = ((0.08, _MOST_M + 0.1), (0.03, 0.9), (0.01, 0.25))
_BAND_CELL_M = 0.005  # within the margin, unless that is wide
_FAR, _NO_WAY = 0, 1  # rows for points beyond all cells, and for no clearance
_NONE: IntArray = np.zeros(0, dtype=np.int64)
_OCTAGON = np.arange(8) * math.pi / 4.0


class ArcReach:
    """The tables of one footprint; `arc_reach` caches those for any point."""

    def __init__(self, footprint: Footprint, only_m: FloatArray | None = None) -> None:
        """`only_m`: the points that will be requested; None: any."""
        self._footprint = footprint
        body = footprint.body
        self._turn_m = float(np.hypot(body[:, 0], body[:, 1]).max())
        self._grids: list[_Grid] = []
        tables, at = [], 2
        margin_m = max(footprint.margins.widths_m)
        for cell_m, beyond_m in _GRIDS_M:
            grid = _Grid(body, cell_m, max(beyond_m, margin_m + cell_m), at)
            self._grids.append(grid)
            tables.append((at, grid.centres(), cell_m, footprint.margins))
            at += grid.count
        self._finer = np.zeros(at, dtype=np.bool_)
        """Per row so far: True if its cell may reach into the next finer grid."""
        for coarse, fine in pairwise(self._grids):
            self._finer[coarse.first : coarse.first + coarse.count] = coarse.meets(fine)
        # Within the margin only the bare outline counts.
        cell_m = _BAND_CELL_M if margin_m < 0.1 else 2.0 * _BAND_CELL_M
        self._band = _Grid(body, cell_m, margin_m + cell_m, 0)
        centres = self._band.centres()
        near = footprint.contains(centres) | (distance_m(body, centres) < cell_m)
        deep = inside(body, centres) & (distance_m(body, centres) > cell_m)
        band = np.flatnonzero(near & ~deep)
        self._band_rows = np.full(self._band.count, _NO_WAY, dtype=np.int64)
        self._band_rows[band] = at + np.arange(len(band))
        tables.append((at, centres[band], cell_m, Margins(0.0, 0.0, 0.0)))
        wanted = np.arange(at + len(band)) if only_m is None else np.unique(self._find(only_m)[0])
        self._rows = np.zeros((at + len(band), arcs.SIZE), dtype=np.uint8)
        self._rows[_FAR] = arcs.FAR
        for first, cells_m, size_m, margins in tables:
            rows = wanted[(wanted >= first) & (wanted < first + len(cells_m))]
            self._rows[rows] = self._table(cells_m[rows - first], size_m, margins)

    def ways(self, points_m: FloatArray, contacts: FloatArray) -> ByteArray:
        """(N, arcs.SIZE) for (N, 2) points in the chair's frame; `contacts`: theirs, by Sweeps.

        A point within the bare outline (a hand, a bag) has only the clearances of single motions.
        """
        rows, within = self._find(points_m)
        found = self._rows.take(rows, axis=0)
        if len(within):
            found[within] = _alone(contacts[within])
        return found

    def least(
        self, points_m: FloatArray, contacts: FloatArray, doubted: IntArray = _NONE
    ) -> ByteArray:
        """(arcs.SIZE,): the minimum over all points but those at `doubted`."""
        rows, within = self._find(points_m)
        if len(doubted):
            rows[doubted] = _FAR
            within = np.setdiff1d(within, doubted) if len(within) else within
        least = self._rows.take(_once(rows), axis=0).min(axis=0, initial=arcs.FAR)
        if len(within):
            least = np.minimum(least, _alone(contacts[within]).min(axis=0))
        return np.asarray(least, dtype=np.uint8)

    def _find(self, points_m: FloatArray) -> tuple[IntArray, IntArray]:
        """The table row of each point, and the indices of those within the bare outline (_FAR)."""
        rows = np.zeros(len(points_m), dtype=np.int64)
        chosen, cells = self._grids[0].find(points_m.T)
        near = points_m.T.take(chosen, axis=1)
        rows[chosen] = cells
        for grid in self._grids[1:]:
            at = self._finer.take(cells).nonzero()[0]
            if not len(at):
                return rows, at
            fits, cells = grid.find(near.take(at, axis=1))
            at = at.take(fits)
            chosen, near = chosen.take(at), near.take(at, axis=1)
            rows[chosen] = cells
        # Only cells of the finest grid can be within the margin.
        close = chosen[self._footprint.contains(near.T)]
        if not len(close):
            return rows, close
        rows[close] = _NO_WAY
        fits, cells = self._band.find(points_m[close].T)
        rows[close[fits]] = self._band_rows[cells]
        within = close[inside(self._footprint.body, points_m[close])]
        rows[within] = _FAR
        return rows, within

    def _table(self, cells_m: FloatArray, cell_m: float, margins: Margins) -> ByteArray:
        # A cell that the footprint reaches without any travel stays so: it is computed no further.
        found = np.zeros((len(cells_m), arcs.SIZE), dtype=np.float32)
        cells = np.concatenate((cells_m.T, np.ones((1, len(cells_m))))).astype(np.float32)
        half_m = cell_m * math.sqrt(0.5)
        parts = _convex_parts(self._footprint, margins, half_m + 0.5 * _STEP_RAD * self._turn_m)
        for quadrant in range(arcs.QUADRANTS):
            ahead, left = quadrant % 2 == codes.DIR_FORWARD, quadrant < 2
            at = quadrant * arcs.ROWS
            open_, reached = cells, np.arange(len(cells_m))
            least = np.full(len(cells_m), np.inf, dtype=np.float32)
            turned = 0.0
            for row, turn_deg in enumerate(arcs.TURNS_DEG):
                while turned < math.radians(turn_deg) - 1e-9:
                    sector = _sector(ahead, left, turned + _STEP_RAD)
                    middle = turned + 0.5 * _STEP_RAD
                    for part in parts:
                        ways = part.ways(open_, middle if left else -middle, sector)
                        np.minimum(least, ways, out=least)
                    turned += _STEP_RAD
                found[reached, at + row] = least
                away = least.nonzero()[0]
                open_, reached, least = open_.take(away, axis=1), reached.take(away), least[away]
        parts = _convex_parts(
            self._footprint, margins, half_m + 0.5 * _BOTH_STEP_RAD * self._turn_m
        )
        for side in range(arcs.SIDES):
            open_, reached = cells, np.arange(len(cells_m))
            for row, turn_deg in enumerate(arcs.BOTH_TURNS_DEG):
                most = math.radians(turn_deg)
                slab = _Slab(side == codes.DIR_FORWARD, most)
                steps = math.ceil(2.0 * most / _BOTH_STEP_RAD)
                least = np.full(len(reached), np.inf, dtype=np.float32)
                for k in range(steps):
                    middle = -most + (k + 0.5) * 2.0 * most / steps
                    for part in parts:
                        np.minimum(least, part.ways(open_, middle, slab), out=least)
                found[reached, arcs.BOTH_AT + side * arcs.BOTH_ROWS + row] = least
        units = np.floor(np.maximum(found, 0.0) * (1000.0 / arcs.UNIT_MM))
        return np.minimum(units, arcs.FAR).astype(np.uint8)


@lru_cache(maxsize=8)
def _kept(corners: tuple[tuple[float, float], ...], margins: Margins) -> ArcReach:
    return ArcReach(Footprint(corners, margins))


def arc_reach(footprint: Footprint) -> ArcReach:
    """The tables of that footprint: computed once, in some tenths of a second, and cached."""
    return _kept(corners_of(footprint), footprint.margins)


def corners_of(footprint: Footprint) -> tuple[tuple[float, float], ...]:
    """The outline's corners, as a key of what is cached for it."""
    return tuple((float(x), float(y)) for x, y in footprint.body)


class _Grid:
    """Square cells round the outline; rows of a table from `first`."""

    def __init__(self, body: FloatArray, cell_m: float, beyond_m: float, first: int) -> None:
        self._cell_m = cell_m
        low = body.min(axis=0) - beyond_m
        shape = np.ceil((body.max(axis=0) + beyond_m - low) / cell_m).astype(int)
        self._low, self._shape = low.tolist(), shape.tolist()
        self._corner, self._counts = low[:, None], shape[:, None].astype(np.uint64)
        self.count = math.prod(self._shape)
        self.first = first

    def centres(self) -> FloatArray:
        xs, ys = (self._low[k] + (np.arange(self._shape[k]) + 0.5) * self._cell_m for k in (0, 1))
        return np.stack(np.meshgrid(xs, ys, indexing="ij"), axis=2).reshape(-1, 2)

    def meets(self, fine: _Grid) -> BoolArray:
        """Which of its cells may share a point with those of `fine`; rather too many."""
        size_m = [count * fine._cell_m + self._cell_m for count in fine._shape]
        beyond = np.array(fine._low) - self._cell_m
        within = self.centres() - beyond
        return np.asarray(
            ((within >= 0.0) & (within <= np.array(size_m) + self._cell_m)).all(axis=1)
        )

    def find(self, points_m: FloatArray) -> tuple[IntArray, IntArray]:
        """Indices of the (2, N) points in it, and the table row of each of them."""
        places = points_m - self._corner
        places *= 1.0 / self._cell_m
        cells = np.floor(places, out=places).astype(np.int64)
        # Unsigned, a cell before the first one is far beyond the last one.
        within = cells.view(np.uint64) < self._counts
        fits = (within[0] & within[1]).nonzero()[0]
        columns, rows = cells.take(fits, axis=1)
        return fits, columns * self._shape[1] + rows + self.first


class _Sector:
    """Travels of up to 1 m in directions from `low` to `high` (radians)."""

    def __init__(self, low: float, high: float) -> None:
        self._middle, self._half = 0.5 * (low + high), 0.5 * (high - low)
        self.normals = (low - math.pi / 2, high + math.pi / 2, low, self._middle, high)

    def support(self, angles: FloatArray) -> FloatArray:
        """How far it reaches along each of these directions."""
        apart = np.abs(half_turn_rad(angles - self._middle))
        return np.maximum(0.0, np.cos(np.maximum(apart - self._half, 0.0)))


class _Slab:
    """Travels of up to 1 m ahead, with the sideways drift of turns up to `most` (radians)."""

    normals = (0.0, math.pi / 2, math.pi, -math.pi / 2)

    def __init__(self, ahead: bool, most: float) -> None:
        self._sign = 1.0 if ahead else -1.0
        self._aside = math.sin(min(most, math.pi / 2))

    def support(self, angles: FloatArray) -> FloatArray:
        """How far it reaches along each of these directions."""
        forward = np.maximum(0.0, self._sign * np.cos(angles))
        return np.asarray(forward + self._aside * np.abs(np.sin(angles)))


def _sector(ahead: bool, left: bool, turn: float) -> _Sector:
    low, high = (0.0, turn) if left else (-turn, 0.0)
    return _Sector(low, high) if ahead else _Sector(math.pi + low, math.pi + high)


class _Part:
    """A convex part of the footprint, to be grown by `grown_m`."""

    def __init__(self, corners_m: FloatArray, grown_m: float) -> None:
        edges = np.roll(corners_m, -1, axis=0) - corners_m
        self._angles = np.concatenate(
            (np.arctan2(edges[:, 1], edges[:, 0]) - math.pi / 2, _OCTAGON)
        )
        self._corners_m, self._grown_m = corners_m, grown_m

    def ways(self, cells: Float32Array, turn: float, reach: _Sector | _Slab) -> Float32Array:
        """The travel after which it, turned by `turn`, can reach each cell, a column of x, y
        and 1; 0: none is needed."""
        angles = np.concatenate((self._angles + turn, reach.normals))
        normals = np.stack((np.cos(angles), np.sin(angles)), axis=1)
        c, s = math.cos(turn), math.sin(turn)
        turned = self._corners_m @ np.array(((c, s), (-s, c)))
        edge_m = (turned @ normals.T).max(axis=0) + self._grown_m
        scale = 1.0 / np.maximum(reach.support(angles), 1e-7)
        # float32 is as fine as 1 um here; 1e-6 m of it must not count as beyond a side.
        sides = np.column_stack((normals, -(edge_m + 2e-6))) * scale[:, None]
        over = sides.astype(np.float32) @ cells
        most: Float32Array = np.maximum(over.max(axis=0), np.float32(0.0))
        return most


def _convex_parts(footprint: Footprint, margins: Margins, grown_m: float) -> list[_Part]:
    # The growth of each part is taken from the margin as far as the margin suffices.
    less = Margins(*(max(0.0, width - grown_m) for width in margins.widths_m))
    return [_Part(part, grown_m) for part in _parts(footprint.body, less)]


def _parts(body: FloatArray, margins: Margins) -> Iterator[FloatArray]:
    grown = Footprint(body.tolist(), margins)
    # The bare polygon comes first where it is not convex; its sides' parts enclose it.
    yield from grown.parts[1:] if len(grown.parts) > 1 else grown.parts


def _once(rows: IntArray) -> IntArray:
    """`rows` without direct repeats: neighbouring points are often in the same cell."""
    changes = (rows[1:] != rows[:-1]).nonzero()[0]
    return np.concatenate((rows.take(changes), rows[-1:]))


def _alone(contacts: FloatArray) -> ByteArray:
    found = np.zeros((len(contacts), arcs.SIZE), dtype=np.uint8)
    scale = 1000.0 / arcs.UNIT_MM
    units = np.minimum(contacts[:, :2] * scale, arcs.FAR).astype(np.uint8)
    for quadrant in range(arcs.QUADRANTS):
        turn = contacts[:, codes.DIR_LEFT + quadrant // 2, None]
        free = (turn >= arcs.TURNS_DEG) * units[:, quadrant % 2, None]
        found[:, quadrant * arcs.ROWS : (quadrant + 1) * arcs.ROWS] = free
    turn = contacts[:, codes.DIR_LEFT :].min(axis=1)[:, None]
    for side in range(arcs.SIDES):
        at = arcs.BOTH_AT + side * arcs.BOTH_ROWS
        found[:, at : at + arcs.BOTH_ROWS] = (turn >= arcs.BOTH_TURNS_DEG) * units[:, side, None]
    return found
