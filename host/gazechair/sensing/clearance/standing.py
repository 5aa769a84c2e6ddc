"""Limits the approach to objects that may be a standing person.

The chair must still be able to stop when the person starts to walk towards it. A walker is
recognised by motion (`movers`). A standing person looks like a pot or a stool, and when they start
half a metre in front of a moving chair, recognition comes too late. So every free-standing object
as wide as a person is treated as one: the distance to it is cut to what the board needs in order to
be slow enough. With the default settings that stops the chair some 0.7 m before it. An object that
has not moved for ten seconds in front of a standing chair counts as furniture: the chair may creep
up to it, until it has turned away from it.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import BoolArray, IntArray
from gazechair.sensing.clearance.stood import AWAY_DEG, HIDDEN_S, LEAST_BEAMS, SAME_M
from gazechair.sensing.clearance.surface import Surfaces
from gazechair.sensing.clearance.zone import Stopping
from gazelink import zone

_WALK_M_S = 1.0
_HARMLESS_M_S = 0.05

APART_M = 0.06
"""Neighbouring beams that differ by more hit different objects."""
_APART_SIGMA = 4.0  # and by more than this many times the noise of a beam
_APART_RAD = 0.03
WIDE_M = 0.08, 0.9
"""A person's least and greatest width: from a leg in trousers to somebody broad, seen askew."""

AGAIN_M = 0.11
"""The board's band before it goes on (BAND_MM) plus the play of a clearance (evaluate)."""
AWAY_M = 0.3
"""Farther away it is another one."""
_STANDS_M_S = 0.03
_STANDS_DEG_S = 3.0


class Approach:
    """How near, and how fast, the chair may approach a possible person in one direction."""

    def __init__(self, stopping: Stopping | None) -> None:
        """`stopping`: that direction's; None: not known, then the chair does not approach."""
        self.creep_way_m = 0.0
        """Clearance to report so that the board limits the chair to creep speed."""
        self.blocked_within_m = np.inf
        """Nearer than this to a possible person, the chair stops."""
        self.again_from_m = np.inf
        """Nearer than this, a standing chair does not go on."""
        self._from_m = self._permits_at_m = np.zeros(0)
        if stopping is None:
            return
        # The distance required for each speed: the person walks until the chair nearly stands.
        still_s = stopping.time_s(_HARMLESS_M_S) - stopping.time_s(0.0)
        walked_m = _WALK_M_S * np.maximum(stopping.times_s - still_s, stopping.time_s(0.0))
        self._from_m = (stopping.stops - stopping.margin + walked_m)[zone.CREEP :]
        self._permits_at_m = stopping.permits_at[zone.CREEP :]
        self.creep_way_m = float(self._permits_at_m[0]) + AGAIN_M
        self.blocked_within_m = float(self._from_m[0])
        self.again_from_m = float(np.interp(self.creep_way_m, self._permits_at_m, self._from_m))

    def reported_m(self, way_m: float) -> float:
        """Clearance to report when a person may stand `way_m` ahead."""
        if math.isinf(way_m):
            return way_m
        if way_m < self.blocked_within_m:
            return 0.0
        reported = float(np.interp(way_m, self._from_m, self._permits_at_m))
        return reported + max(0.0, way_m - float(self._from_m[-1]))


def like_persons(seen: Surfaces, where: BoolArray | None = None) -> list[IntArray]:
    """For each object as wide as a person, the indices of its points.

    `where`: (N,), only objects with a point for which it is True; None: all.
    """
    points_m = seen.points_m
    if len(points_m) < LEAST_BEAMS:
        return []
    # From each beam to the next, round the circle: an object may be straight behind the lidar.
    ranges_m = seen.ranges_m
    step_m = np.abs(np.concatenate((ranges_m[1:], ranges_m[:1])) - ranges_m)
    apart = step_m > max(APART_M, _APART_SIGMA * seen.noise_m)
    apart |= seen.turns_rad > _APART_RAD
    ends = apart.nonzero()[0]
    if not len(ends):
        return []
    firsts = np.concatenate((ends[-1:] + 1 - len(points_m), ends[:-1] + 1))
    x, y = points_m.T.take(ends, axis=1) - points_m.T.take(firsts, axis=1)
    wide_m = np.hypot(x, y)
    wide = (wide_m >= WIDE_M[0]) & (wide_m <= WIDE_M[1])
    wide &= ends - firsts + 1 >= LEAST_BEAMS
    if where is not None:
        counted = where.nonzero()[0]  # twice: the first object may begin before the first point
        counted = np.concatenate((counted - len(points_m), counted))
        wide &= counted.searchsorted(ends, "right") > counted.searchsorted(firsts)
    found = wide.nonzero()[0].tolist()
    objects = [np.arange(firsts[one], ends[one] + 1) % len(points_m) for one in found]
    # The ends of walls all round the lidar are close together, too.
    return [one for one in objects if (np.ptp(points_m[one], axis=0) <= WIDE_M[1]).all()]


class Standing:
    """Judges one direction, forward or backward, of one lidar's views in their order."""

    def __init__(self) -> None:
        self.approach = Approach(None)
        """By the board's stopping distances; may be replaced at any time."""
        self._near_m = np.inf
        self._seen_s = 0.0
        self._since_deg = 0.0
        self._furniture = False

    def update(
        self, way_m: float, stood: bool, walks: bool, turned_deg: float, at_s: float
    ) -> float:
        """Clearance to report; inf for no limit.

        `way_m`: distance to the nearest possible person. `stood`: this one has stood for ten
        seconds before the standing chair. `walks`: some object approaches. `turned_deg`: how far
        the chair has turned since whenever.
        """
        approach = self.approach
        reported_m = approach.reported_m(way_m)
        if self._furniture:
            hidden = way_m >= self._near_m + AWAY_M
            if not hidden:
                self._seen_s = at_s
            turned = abs(turned_deg - self._since_deg) > AWAY_DEG
            self._furniture = not walks and not turned and at_s - self._seen_s < HIDDEN_S
            if self._furniture:
                return reported_m if hidden else max(approach.creep_way_m, reported_m)
        if stood and way_m < approach.again_from_m + SAME_M:
            self._furniture = True
            self._near_m, self._seen_s, self._since_deg = way_m, at_s, turned_deg
            return max(approach.creep_way_m, reported_m)
        return reported_m


def stands(speed_m_s: float, rate_deg_s: float) -> bool:
    """True if a chair with this measured motion counts as standing."""
    return abs(speed_m_s) < _STANDS_M_S and abs(rate_deg_s) < _STANDS_DEG_S
