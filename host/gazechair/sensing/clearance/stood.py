"""Which surfaces have stood where they are while the chair stood, whatever they look like.

The end of a wall seen at a small angle is a part of that wall in one scan and as wide as a person
in the next. So not the objects are compared with earlier ones, but what the lidar sees in each
degree about it.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.sensing.clearance.degrees import bins_of
from gazechair.sensing.clearance.surface import Surfaces
from gazechair.sensing.lidar.blind import BINS

CALM_S = 10.0
"""What has stood for this long is furniture."""
HIDDEN_S = 1.0
"""For this long it may not be seen in between."""
SAME_M = 0.05
"""What is nearer or farther away by more has moved."""
AWAY_DEG = 10.0
"""After a turn by more than this it counts as another."""
LEAST_BEAMS = 3
"""Fewer are no object."""


class Stood:
    """One lidar's memory of a standing chair. Call `update` with every view."""

    def __init__(self) -> None:
        self._ranges_m: FloatArray | None = None  # per degree; inf: nothing; None: not standing
        self._since_s = self._seen_s = np.zeros(BINS)
        self._since_deg = 0.0

    def restart(self) -> None:
        """The chair moves, or somebody approaches it: nothing has stood so far."""
        self._ranges_m = None

    def update(
        self, seen: Surfaces, things: list[IntArray], turned_deg: float, at_s: float
    ) -> list[bool]:
        """For each of the `things` (indices of points): whether it has stood for CALM_S.

        The first view with a thing begins; what a thing has covered or uncovered since then has not
        stood. `turned_deg`: how far the chair has turned since whenever; slowly, it stands.
        """
        if abs(turned_deg - self._since_deg) > AWAY_DEG:
            self.restart()
        if self._ranges_m is None and not things:
            return []
        bins = bins_of(seen.bearings_rad)
        nearest_m = np.full(BINS, np.inf)
        np.minimum.at(nearest_m, bins, seen.ranges_m)
        if self._ranges_m is None:
            self._ranges_m, self._since_deg = nearest_m, turned_deg
            self._since_s, self._seen_s = np.full(BINS, at_s), np.full(BINS, at_s)
        late = self._compare(bins, seen.ranges_m, nearest_m, at_s)
        return [bool(np.count_nonzero(late[thing]) < LEAST_BEAMS) for thing in things]

    def _compare(
        self, bins: IntArray, ranges_m: FloatArray, nearest_m: FloatArray, at_s: float
    ) -> BoolArray:
        # True for each point that has not stood where it is.
        assert self._ranges_m is not None
        kept_m = self._ranges_m
        still = np.isinf(kept_m)
        late = np.ones(len(bins), dtype=np.bool_)
        for beside in (-1, 0, 1):  # on a slant surface the beams seldom meet the same place
            there = (bins + beside) % BINS
            same = np.abs(kept_m.take(there) - ranges_m) <= SAME_M
            still[there[same]] = True
            late &= ~same
        moved = (nearest_m < kept_m - SAME_M) | (at_s - self._seen_s > HIDDEN_S)
        self._seen_s[still] = at_s
        kept_m[moved] = nearest_m[moved]
        self._since_s[moved] = self._seen_s[moved] = at_s
        return np.asarray(late | (at_s - self._since_s.take(bins) < CALM_S))
