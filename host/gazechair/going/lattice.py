"""Search over place and heading: cost from every pose to the goal, by a wave of numpy steps.

A lattice of 7.5 cm and 16 headings, laid along the map's walls. A move goes forward along the
heading or turns on the spot by one heading; both end on the lattice exactly. One unit of cost is
about 70 ms of a slow chair; narrow places cost more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from gazechair.base.arrays import BoolArray, Float32Array, FloatArray, Int32Array, IntArray
from gazechair.going.costmap import Costmap
from gazechair.going.distance_field import Distances, distances

STEP_M = 0.075
_STEPS = np.array((
    (1, 0), (2, 1), (1, 1), (1, 2), (0, 1), (-1, 2), (-1, 1), (-2, 1),
    (-1, 0), (-2, -1), (-1, -1), (-1, -2), (0, -1), (1, -2), (1, -1), (2, -1),
))  # fmt: skip
HEADINGS = len(_STEPS)
_ANGLES = np.unwrap(np.arctan2(_STEPS[:, 1], _STEPS[:, 0]))
_STRAIGHT = np.round(5.0 * np.hypot(_STEPS[:, 0], _STEPS[:, 1])).astype(np.int64)
_LEAST_COST = 5
_TURN_COST = 18
_NARROW_TURN_COST = 12
UNREACHED = np.iinfo(np.int32).max
LOOSE_M, STRICT_M = -0.03, 0.0
"""Least clearance of a pose; loose, as smoothing centres what only the lattice does not fit."""
NO_TURN_M = 0.15
"""No turn is planned within this distance of a place where the board refused one."""
_EASIER_M = 0.03
_EASY_M = 0.15  # clearance from which on there is no extra cost
_NARROW = 3.0  # extra cost at no clearance, in multiples of the step's own
_STOP_M, _FREE_M = 0.30, 0.75  # distances ahead at which the board stops, and creeps
_CREEPS = 5.0
_JAMS_M, _JAMS = 0.05, 6.0
_STANDING = 6.0  # the same, where the board may see a standing person ahead
_BLOCKED = -1.0
_BORDER = 3


class Lattice:
    """The poses of one costmap; when that has changed, `refresh` and then `use`."""

    def __init__(self, costmap: Costmap) -> None:
        self._costmap = costmap
        nx, ny = costmap.shape
        self.turned_rad = _walls_rad(costmap)
        c, s = math.cos(self.turned_rad), math.sin(self.turned_rad)
        self._turn = np.array(((c, s), (-s, c)))  # for row vectors: lattice to map
        size = np.array((nx, ny)) * float(costmap.cell_m)
        corners = np.array(((0.0, 0.0), (size[0], 0.0), (0.0, size[1]), tuple(size)))
        corners = (corners + costmap.low_m) @ self._turn.T
        self._low = corners.min(axis=0)
        shape = np.ceil((corners.max(axis=0) - self._low) / STEP_M).astype(int) + 1
        self._shape: tuple[int, int] = (int(shape[0]), int(shape[1]))
        self._layer = int(shape.prod())
        self.headings_rad = _ANGLES + self.turned_rad
        self._changes = costmap.changes
        self._least_m, self._turn_m = LOOSE_M, 0.0
        self._no_turns: list[tuple[float, float]] = []
        self._still = self._clearances(np.arange(self._layer))
        self._clear = self._still
        self._field: Distances | None = None
        """The distances of `_clear`; None: to be computed from the map's."""
        self._stood = self._cells(costmap.standing_in_map_m)
        self._stood_ahead = self._ahead_of(self._stood)
        self._standing_ahead = self._with_standing()
        self._is_prepared = False
        self.use(LOOSE_M, 0.0, ())

    def _clearances(self, places: IntArray) -> Float32Array:
        """Clearance (2 HEADINGS, len(places)) at each heading, and halfway to the next one."""
        x, y = self.metres(places).T
        found = np.full((2 * HEADINGS, len(places)), _BLOCKED, dtype=np.float32)
        i, j = np.divmod(places, self._shape[1])
        within = (i >= _BORDER) & (i < self._shape[0] - _BORDER)
        within &= (j >= _BORDER) & (j < self._shape[1] - _BORDER)
        cost = self._costmap
        cx = ((x - cost.low_m[0]) / cost.cell_m).astype(int)
        cy = ((y - cost.low_m[1]) / cost.cell_m).astype(int)
        within &= (cx >= 0) & (cx < cost.shape[0]) & (cy >= 0) & (cy < cost.shape[1])
        at = np.flatnonzero(within)
        at = at[cost.distances_m[cx[at], cy[at]] > 0.2]
        ends = np.append(_ANGLES, _ANGLES[0] + 2.0 * math.pi)
        for k in range(HEADINGS):
            for half in (0, 1):
                angle = self.turned_rad + ends[k] + 0.5 * half * (ends[k + 1] - ends[k])
                found[2 * k + half, at] = cost.clearance_m(x[at], y[at], float(angle))
        return found

    def refresh(self) -> None:
        """Bring it up to date with the costmap."""
        cost = self._costmap
        changes, field = cost.changes, cost.distances_m  # which may change meanwhile
        if self._changes == changes:
            return
        clear, before = self._clear, self._field
        if before is None:
            clear, before = self._still, cost.static_m
        near = self._near_changes(before, field)
        if near.any():
            clear = clear.copy()
            clear[:, near] = self._clearances(np.flatnonzero(near))
        standing_ahead = self._with_standing()
        # All of it, or nothing: what raises above leaves the lattice as it was.
        self._clear, self._standing_ahead, self._is_prepared = clear, standing_ahead, False
        self._changes = changes
        self._field = field if cost.distances_m is field and cost.changes == changes else None

    def _near_changes(self, before: Distances, after: Distances) -> BoolArray:
        """Places whose clearance differs, unless it is easy with both distance fields."""
        cost = self._costmap
        matters = (before != after) & (np.minimum(before, after) < cost.disc_m + _EASY_M)
        at_m = (np.argwhere(matters) + 0.5) * cost.cell_m + cost.low_m
        cells = np.zeros(self._shape, dtype=np.bool_)
        cells[tuple(self._nearest(at_m).T)] = True
        reach = cost.reach_m + 2.0 * STEP_M
        return np.asarray((distances(cells, STEP_M, reach + STEP_M) <= reach).reshape(-1))

    def _ahead(self, whole: Float32Array, way_m: float) -> Float32Array:
        """Clearance at the place `way_m` ahead of each pose."""
        found = np.full_like(whole, _BLOCKED)
        for k, (i, j) in enumerate(_STEPS):
            steps = round(way_m / (STEP_M * math.hypot(i, j)))
            shift = steps * int(i * self._shape[1] + j)
            if shift >= 0:
                found[k, : self._layer - shift] = whole[k, shift:]
            else:
                found[k, -shift:] = whole[k, :shift]
        return found

    def _nearest(self, places_m: FloatArray) -> IntArray:
        """The nearest cell of each place (N, 2) in the map's frame."""
        cells = np.round((places_m @ self._turn.T - self._low) / STEP_M)
        return np.asarray(cells, dtype=np.int64)

    def _with_standing(self) -> BoolArray:
        """(HEADINGS, places): poses with a possible standing person close ahead."""
        new = np.setdiff1d(self._cells(self._costmap.standing_m), self._stood)
        return self._stood_ahead | self._ahead_of(new) if len(new) else self._stood_ahead

    def _cells(self, places_m: FloatArray) -> IntArray:
        """Indices of the places' nearest cells, each once."""
        return np.unique(self._nearest(places_m) @ (self._shape[1], 1))

    def _ahead_of(self, at: IntArray) -> BoolArray:
        """(HEADINGS, places): poses with one of these cells close ahead."""
        cells = np.stack(np.divmod(at, self._shape[1]), axis=1)
        found = np.zeros((HEADINGS, *self._shape), dtype=np.bool_)
        ahead = self._costmap.ahead
        reach = math.ceil((ahead.reach_m[1] + ahead.half_m) / STEP_M)
        steps = np.stack(np.meshgrid(*2 * [np.arange(-reach, reach + 1)]), axis=2).reshape(-1, 2)
        for k, angle in enumerate(_ANGLES):
            along = STEP_M * (steps @ (math.cos(angle), math.sin(angle)))
            across = STEP_M * (steps @ (-math.sin(angle), math.cos(angle)))
            met = (along > ahead.reach_m[0]) & (along < ahead.reach_m[1])
            met &= np.abs(across) < ahead.half_m
            places = (cells[:, None, :] - steps[met]).reshape(-1, 2)
            within = ((places >= 0) & (places < self._shape)).all(axis=1)
            found[k, places[within, 0], places[within, 1]] = True
        return found.reshape(HEADINGS, -1)

    def use(self, least_m: float, turn_m: float, no_turns: Sequence[tuple[float, float]]) -> None:
        """Set the least clearance of free poses and of turns; no turn is free near `no_turns`."""
        asked = least_m, turn_m, list(no_turns)
        if not self._is_prepared or asked != (self._least_m, self._turn_m, self._no_turns):
            self._least_m, self._turn_m, self._no_turns = asked
            self._prepare()
            self._is_prepared = True

    def _prepare(self) -> None:
        whole, half = self._clear[::2], self._clear[1::2]
        least = self._least_m
        narrow = np.clip((_EASY_M - whole) / _EASY_M, 0.0, 1.2)
        self._free = ((whole >= least) & (self._ahead(whole, _STOP_M) >= least)).reshape(-1)
        self._stands = (whole >= least).reshape(-1)
        creeps = self._ahead(whole, _FREE_M) < least
        dearer = _NARROW * narrow + _CREEPS * creeps + _JAMS * (whole < _JAMS_M)
        dearer += _STANDING * self._standing_ahead
        self._dearer = (256.0 * dearer).astype(np.int64).reshape(-1)
        # Turning from k to k + 1 must be free half a heading beyond: the board wants room to stop.
        after, beyond = np.roll(whole, -1, axis=0), np.roll(half, -1, axis=0)
        before, past = np.roll(half, 1, axis=0), np.roll(whole, 1, axis=0)
        between = np.minimum(np.minimum(whole, half), after)
        self._left = (np.minimum(between, beyond) >= self._turn_m).reshape(-1)
        self._right = (np.minimum(between, before) >= self._turn_m).reshape(-1)
        self._tight = (np.minimum(between, past) < self._turn_m + _EASIER_M).reshape(-1)
        for x, y in self._no_turns:
            u, v = (np.array((x, y)) @ self._turn.T - self._low) / STEP_M
            i, j = np.divmod(np.arange(self._layer), self._shape[1])
            near = np.tile(np.hypot(i - u, j - v) * STEP_M < NO_TURN_M, HEADINGS)
            self._left &= ~near
            self._right &= ~near

    # -- places ------------------------------------------------------------------------------------

    def metres(self, places: IntArray) -> FloatArray:
        """(N, 2) in the map's frame."""
        cells = np.stack(np.divmod(places % self._layer, self._shape[1]), axis=1)
        return np.asarray((cells * STEP_M + self._low) @ self._turn)

    def near(
        self, x_m: float, y_m: float, heading_rad: float, within_m: float, turned_rad: float
    ) -> IntArray:
        """Free poses within `within_m` and `turned_rad` of a pose."""
        u, v = (np.array((x_m, y_m)) @ self._turn.T - self._low) / STEP_M
        reach = math.ceil(within_m / STEP_M)
        found = []
        for i in range(max(0, round(u) - reach), min(self._shape[0], round(u) + reach + 1)):
            for j in range(max(0, round(v) - reach), min(self._shape[1], round(v) + reach + 1)):
                if math.hypot(i - u, j - v) * STEP_M > within_m:
                    continue
                for k in range(HEADINGS):
                    off = math.remainder(self.headings_rad[k] - heading_rad, 2.0 * math.pi)
                    at = k * self._layer + i * self._shape[1] + j
                    if abs(off) <= turned_rad and self._stands[at]:
                        found.append(at)
        return np.array(found, dtype=np.int64)

    def heading_rad(self, pose: int) -> float:
        """Heading of a lattice pose, in the map's frame."""
        return float(self.headings_rad[pose // self._layer])

    # -- search ------------------------------------------------------------------------------------

    def costs_to(
        self,
        goals: IntArray,
        prices: IntArray,
        starts: IntArray,
        go_on: Callable[[], None] = lambda: None,
    ) -> Int32Array:
        """Cost from each pose to the cheapest of `goals`; ends soon after a start is settled.

        `go_on` is called again and again; what it raises ends the search.
        """
        costs = np.full(HEADINGS * self._layer, UNREACHED, dtype=np.int32)
        np.minimum.at(costs, goals, prices.astype(np.int32))
        first = np.empty(len(costs), dtype=np.int64)
        waiting = goals
        spare = 40
        while len(waiting):
            go_on()
            # No move is cheaper than the least: none leads from these to one of them.
            found = costs[waiting]
            settled = (int(found.min()) // _LEAST_COST + 1) * _LEAST_COST
            due = found < settled
            poses, waiting = waiting[due], waiting[~due]
            count = np.arange(len(poses))
            first[poses] = count
            poses = poses[first[poses] == count]
            before, price = self._before(poses)
            cost = np.tile(costs[poses], len(price) // len(poses)) + price
            better = (price >= 0) & (cost < costs[before])
            before = before[better]
            np.minimum.at(costs, before, cost[better].astype(np.int32))
            waiting = np.concatenate((waiting, before))
            if len(starts) and (costs[starts] < settled).any():
                spare -= 1
                if spare < 0:
                    break
        return costs

    def _before(self, poses: IntArray) -> tuple[IntArray, IntArray]:
        """The poses before `poses`, move by move, and the price of each; -1: not possible."""
        layer, heading = self._layer, poses // self._layer
        place = poses % layer
        found, prices = [], []
        for side, turns in ((1, self._left), (-1, self._right)):
            # Turned left from heading - 1, or right from heading + 1.
            other = (heading - side) % HEADINGS
            before = other * layer + place
            # `_left` is stored at the heading it starts from, `_right` at the one it ends in.
            at = before if side > 0 else poses
            found.append(before)
            prices.append(np.where(turns[at], _TURN_COST + _NARROW_TURN_COST * self._tight[at], -1))
        step = _STEPS[heading] @ np.array((self._shape[1], 1))
        before = poses - step
        before = np.where((before >= heading * layer) & (before < (heading + 1) * layer), before, 0)
        straight = _STRAIGHT[heading]
        price = straight + (straight * self._dearer[before] >> 8)
        found.append(before)
        prices.append(np.where(self._stands[before] & self._free[poses], price, -1))
        return np.concatenate(found), np.concatenate(prices)

    def route(self, costs: Int32Array, start: int) -> list[int]:
        """Poses from `start` down to the goal."""
        found = [start]
        layer = self._layer
        while True:
            at = found[-1]
            heading, place = divmod(at, layer)
            left = ((heading + 1) % HEADINGS) * layer + place
            right = ((heading - 1) % HEADINGS) * layer + place
            ahead = at + int(_STEPS[heading] @ np.array((self._shape[1], 1)))
            options = []
            if self._left[at]:
                options.append((int(costs[left]) + self._turn_cost(at), left))
            if self._right[right]:
                options.append((int(costs[right]) + self._turn_cost(right), right))
            if self._free[ahead] and self._stands[at]:
                straight = int(_STRAIGHT[heading])
                straight += straight * int(self._dearer[at]) >> 8
                options.append((int(costs[ahead]) + straight, ahead))
            best = min(options, default=(UNREACHED, at))
            if costs[best[1]] >= costs[at]:
                return found
            found.append(best[1])

    def _turn_cost(self, kept_at: int) -> int:
        return _TURN_COST + _NARROW_TURN_COST * int(self._tight[kept_at])


def _walls_rad(costmap: Costmap) -> float:
    """Angle, -45..45 degrees, along which most walls line up; 0 where hardly any are known."""
    occupied = np.argwhere(costmap.known_m <= 0.0)
    if len(occupied) < 20:
        return 0.0
    points = occupied[:: max(1, len(occupied) // 4000)].astype(np.float64) * costmap.cell_m
    best = (-1.0, 0.0, 0.0)
    for deg in np.arange(-45.0, 45.0, 1.0):
        best = max(best, (_lined_up(points, math.radians(deg)), -abs(deg), deg))[:3]
    return math.radians(best[2])


def _lined_up(points: FloatArray, angle: float) -> float:
    c, s = math.cos(angle), math.sin(angle)
    total = 0.0
    for across in (points @ (c, s), points @ (-s, c)):
        bins = np.bincount(((across - across.min()) / 0.05).astype(np.int64))
        total += float((bins.astype(np.float64) ** 2).sum())
    return total
