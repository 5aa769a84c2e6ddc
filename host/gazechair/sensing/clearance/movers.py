"""Detects objects that approach the chair, such as people.

A stop distance assumes standing objects. A person who walks continues to walk while the chair
stops, so the distance walked until then is subtracted from the clearance.

The view of 0.2 s ago, moved as the chair has moved since, should equal the present view. The
chair's motion is the one for which the two agree best (least squares over forward speed and turn
rate, outliers weighted down: most objects around a chair do stand). An object that is then nearer
than expected, over at least three degrees, approaches by itself.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.sensing.clearance.degrees import BIN_RAD, bins_of
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazechair.sensing.lidar.blind import BINS

_BACK_S = (0.15, 0.20, 0.35)  # least, preferred, most time between the two views
_EVERY_S = 0.045  # two quarter turns
_FAR_M = 15.0
_MOVER_FAR_M = 4.5
_STEP_M = 0.5  # a greater change: another object came into view
_EDGE_M = 0.4
_LEAST_BINS = 40
_PASSES = 3
_DOUBT_M = 0.03
_STAYS = 1e-3  # regularisation: without features the motion stays as it was
_SETTLED_M, _SETTLED_RAD = 5e-4, 2e-4  # less than 1 % of what reveals a walker
_LEAST_M_S = 0.3
_MOST_M_S = 1.6
_PLACES = np.linspace(0.0, 1.0, 9)[1:]  # along the walker's path
_THETA = (np.arange(BINS) + 0.5) * BIN_RAD
_COS, _SIN = np.cos(_THETA), np.sin(_THETA)
_AFTER, _AHEAD = np.roll(np.arange(BINS), -1), np.roll(np.arange(BINS), 1)
_TURNING_DEG_S = 15.0  # in faster turns two views have too little in common


class Movers:
    """One lidar's movers; `origin_m`: where it sits. Call `update` with every view."""

    def __init__(self, origin_m: tuple[float, float]) -> None:
        self._origin = np.array(origin_m)[:, None]
        x, y = origin_m
        self._across, self._along = y * _COS - x * _SIN, y * _SIN + x * _COS
        # Points here are two rows, x and y: numpy is slow with many rows of two.
        self._views: deque[tuple[float, FloatArray]] = deque(maxlen=16)
        self._coming = np.zeros(BINS)
        self.zone: StopZone = UNKNOWN
        self.speed_m_s = 0.0
        """The chair's own forward speed and turn rate, as far as the views show them."""
        self.rate_deg_s = 0.0
        self.turned_deg = 0.0
        """By how much it has turned since the first view, by that rate."""

    def update(self, points_m: FloatArray, at_s: float) -> FloatArray:
        """(M, 2): the places that approaching objects reach until the chair has stopped.

        In the chair's frame. `points_m`: (N, 2), smoothed, of the view acquired at `at_s`.
        """
        if not self._views or not 0.0 <= at_s - self._views[-1][0] < _EVERY_S:
            self._coming = self._compare(np.ascontiguousarray(points_m.T), at_s)
        return self._ahead(points_m.T) if np.count_nonzero(self._coming) else np.zeros((0, 2))

    def _compare(self, points_m: FloatArray, at_s: float) -> FloatArray:
        """Approach speed of the object in each degree, m/s; 0 if it stands or recedes."""
        before = self._before(at_s)
        newest_s = self._views[-1][0] if self._views else at_s
        self._views.append((at_s, points_m))
        if before is None:
            return np.zeros(BINS)
        elapsed_s = at_s - before[0]
        now = self._ranges(points_m)
        gap, slant = self._align(before[1], now, elapsed_s)
        self.turned_deg += self.rate_deg_s * (at_s - newest_s)
        if abs(self.rate_deg_s) > _TURNING_DEG_S:
            return np.zeros(BINS)
        nearer = -gap / slant / elapsed_s
        coming = _wide((nearer > _LEAST_M_S) & (now < _MOVER_FAR_M))
        return np.where(coming, np.minimum(nearer, _MOST_M_S), 0.0)

    def _before(self, at_s: float) -> tuple[float, FloatArray] | None:
        views = self._views
        while views and not 0.0 < at_s - views[0][0] <= _BACK_S[2]:
            views.popleft()
        old = [view for view in views if at_s - view[0] >= _BACK_S[0]]
        return min(old, key=lambda view: abs(at_s - view[0] - _BACK_S[1])) if old else None

    def _ranges(self, points_m: FloatArray) -> FloatArray:
        """The nearest range in each degree about the lidar; inf for none."""
        x, y = points_m - self._origin
        squared = np.full(BINS, np.inf)
        np.minimum.at(squared, bins_of(np.arctan2(y, x)), x * x + y * y)
        nearest: FloatArray = np.sqrt(squared)  # one root a degree
        return nearest

    @np.errstate(invalid="ignore")  # inf - inf in degrees without a return
    def _align(
        self, before: FloatArray, now: FloatArray, elapsed_s: float
    ) -> tuple[FloatArray, FloatArray]:
        """Gap per degree (now minus expected, m; 0 where unknown) and its slant."""
        c, s = _COS, _SIN
        across = now.take(_AFTER) - now.take(_AHEAD)
        smooth = (np.abs(across) < _EDGE_M) & (now < _FAR_M)
        slope = np.where(smooth, across / (2.0 * BIN_RAD), 0.0)
        ratio = np.where(smooth, slope / np.where(smooth, now, 1.0), 0.0)
        slant = np.sqrt(1.0 + ratio**2)
        # How the range in a fixed direction changes with the chair's travel and turn.
        of_way = (-c - ratio * s) / slant
        of_turn = (self._across + ratio * self._along + slope) / slant
        changes = np.array((of_way, of_turn))
        way_m, turn = self.speed_m_s * elapsed_s, math.radians(self.rate_deg_s) * elapsed_s
        gap = np.zeros(BINS)
        for _ in range(_PASSES):
            raw = now - self._ranges(_moved(before, way_m, turn))
            known = smooth & (np.abs(raw) < _STEP_M)
            gap = np.where(known, raw, 0.0)
            here = known.nonzero()[0]
            if len(here) < _LEAST_BINS:
                way_m = turn = 0.0
                break
            rest = gap.take(here) / slant.take(here)
            weight = 1.0 / (1.0 + (rest / _DOUBT_M) ** 2)
            change_m, change = _least_squares(changes.take(here, axis=1), weight, rest)
            way_m, turn = way_m + change_m, turn + change
            if abs(change_m) < _SETTLED_M and abs(change) < _SETTLED_RAD:
                break
        self.speed_m_s = way_m / elapsed_s
        self.rate_deg_s = math.degrees(turn) / elapsed_s
        return gap, slant

    def _ahead(self, points_m: FloatArray) -> FloatArray:
        offset = points_m - self._origin
        speed = self._coming.take(bins_of(np.arctan2(offset[1], offset[0])))
        chosen = (speed > 0.0).nonzero()[0]
        offset, speed = offset.take(chosen, axis=1).T, speed.take(chosen)
        ranges = np.hypot(offset[:, 0], offset[:, 1])
        stop_s = self.zone.time_s(self.speed_m_s)
        left = np.maximum(1.0 - speed[:, None] * stop_s * _PLACES / ranges[:, None], 0.0)
        found = offset[:, None, :] * left[:, :, None] + self._origin[:, 0]
        return np.ascontiguousarray(found).reshape(-1, 2)


def _moved(points: FloatArray, way_m: float, turn: float) -> FloatArray:
    """Where standing points are in the frame of a chair that has moved."""
    c, s = math.cos(turn), math.sin(turn)
    offset = points - ((way_m * math.cos(turn / 2.0),), (way_m * math.sin(turn / 2.0),))
    return np.asarray(c * offset + ((s,), (-s,)) * offset[::-1])


def _least_squares(rows: FloatArray, weight: FloatArray, rest: FloatArray) -> tuple[float, float]:
    """The two factors with which (2, N) `rows` add up to `rest` (N,) best, weighted."""
    weighted = rows * weight
    (a, b), (_, d) = (weighted @ rows.T).tolist()
    p, q = (weighted @ rest).tolist()
    a, d = a + _STAYS, d + _STAYS
    whole = a * d - b * b  # both squares have _STAYS more: never 0
    return (d * p - b * q) / whole, (a * q - b * p) / whole


def _wide(flags: BoolArray) -> BoolArray:
    """`flags` only where they belong to a run of at least three, round the circle."""
    if not np.count_nonzero(flags):
        return flags
    middle = flags & flags.take(_AFTER) & flags.take(_AHEAD)
    return np.asarray(middle | middle.take(_AFTER) | middle.take(_AHEAD))
