"""How far each motion may go by one lidar: its newest view, filtered, against the footprint.

Within the stop zone a single beam counts. Beyond it an obstacle needs two neighbouring beams,
or the same place in two turns: an isolated return far ahead slows nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gazechair.base.arrays import BoolArray, ByteArray, FloatArray, IntArray
from gazechair.base.footprint import Footprint
from gazechair.sensing.clearance.arcs import arc_reach
from gazechair.sensing.clearance.movers import Movers
from gazechair.sensing.clearance.standing import (
    AGAIN_M,
    APART_M,
    AWAY_M,
    Approach,
    Standing,
    like_persons,
    stands,
)
from gazechair.sensing.clearance.stood import Stood
from gazechair.sensing.clearance.surface import Surfaces, surfaces
from gazechair.sensing.clearance.sweeps import Sweeps
from gazechair.sensing.clearance.walls import askew, goes_on
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazechair.sensing.lidar.scan import ChairView
from gazelink import arcs, codes
from gazelink.zone import CREEP

_SAME_PLACE_M = 0.25  # within a turn of the lidar the chair moves and turns by about as much
_TURN_S = (0.06, 0.35)  # age of another turn: least, most
_OLD_S = 0.15  # oldest view of another lidar that counts

Reach = tuple[float, float, float, float]
"""Metres forward and backward, degrees left and right; inf = free as far as the lidar sees."""

FREE: Reach = (math.inf, math.inf, math.inf, math.inf)
_ROUNDING_M = 1e-9
_ARC_RANGE_M = 4.5  # from a lidar: no farther point limits an arc
NOTHING_NEAR: ByteArray = np.full(arcs.SIZE, arcs.FAR, dtype=np.uint8)


class LidarReach:
    """Evaluates the views of one lidar in the order in which they arrive."""

    def __init__(self, footprint: Footprint) -> None:
        self._sweeps = Sweeps(footprint)
        self._arcs = arc_reach(footprint)
        self.arcs: ByteArray = NOTHING_NEAR
        """Of the newest view: how far the chair may travel while it turns, see gazelink.arcs."""
        across_m = np.concatenate(footprint.parts)[:, 1]
        self._across_m = (across_m.min(), across_m.max())
        self._movers: Movers | None = None
        self._standing = {way: Standing() for way in (codes.DIR_FORWARD, codes.DIR_BACKWARD)}
        self._stood = Stood()
        self.seen_m: FloatArray = np.zeros((0, 2))
        """The newest view, in the chair's frame, and when it was acquired."""
        self.seen_s = -math.inf
        self._others: list[FloatArray] = []
        self._speckles = _Speckles()
        self._arc_speckles = _Speckles()
        self.use(UNKNOWN)

    def use(self, zone: StopZone) -> None:
        """Use another stop zone from now on."""
        self._zone = zone
        backward = zone.of(codes.DIR_BACKWARD)
        self._margin_m = 0.0 if backward is None else backward.margin
        forward = zone.of(codes.DIR_FORWARD)
        self._creeps_m = 0.0 if forward is None else float(forward.permits_at[CREEP]) + AGAIN_M
        # A bend that is longer limits nothing.
        self._bend_m = math.inf if backward is None else float(backward.permits_at.max())
        self._arc_zone = 1000.0 * zone.far[: codes.DIR_LEFT].max() / arcs.UNIT_MM
        for direction, standing in self._standing.items():
            standing.approach = Approach(zone.of(direction))
        if self._movers is not None:
            self._movers.zone = zone

    def update(self, view: ChairView, others: Sequence[LidarReach] = ()) -> Reach:
        """The reach of each motion, in the order of codes.DIRECTIONS; `others`: other lidars."""
        now_s = view.acquired_s
        self._others = [one.seen_m for one in others if now_s - one.seen_s < _OLD_S]
        self.seen_m, self.seen_s = view.points_m, view.acquired_s
        if not len(view.points_m):
            self.arcs = NOTHING_NEAR
            return FREE
        seen = surfaces(view.points_m, view.origin_m, view.polar)
        contacts = self._sweeps.contacts(seen.points_m)
        lone = seen.lone.nonzero()[0]
        speckle = lone[contacts.T.take(lone, axis=1).min(axis=0) < math.inf]
        doubted = speckle[~self._speckles.again(seen.points_m[speckle], view.acquired_s)]
        self.arcs = self._arcs_of(seen, contacts, view.acquired_s)
        if len(doubted):
            far = contacts[doubted]
            contacts[doubted] = np.where(far > self._zone.far, np.inf, far)
        least = contacts.min(axis=0)
        backward_m = float(least[codes.DIR_BACKWARD])
        least[codes.DIR_BACKWARD] = min(backward_m, self._bent(seen, doubted, backward_m))
        if np.count_nonzero(self._sweeps.alongside(seen.points_m)):
            # Nearer than the heading's error at speed: only creep, so a person there can get away.
            least[codes.DIR_FORWARD] = min(least[codes.DIR_FORWARD], self._creeps_m)
        if self._movers is None:
            self._movers = Movers(view.origin_m)
            self._movers.zone = self._zone
        coming = self._movers.update(seen.points_m, view.acquired_s)
        walks = bool(len(coming))
        persons = self._persons(seen)
        if walks or not stands(self._movers.speed_m_s, self._movers.rate_deg_s):
            self._stood.restart()
        stood = self._stood.update(seen, persons, self._movers.turned_deg, view.acquired_s)
        ways_m = [contacts[one].min(axis=0).tolist() for one in persons]
        for direction, standing in self._standing.items():
            way_m = min((ways[direction] for ways in ways_m), default=math.inf)
            pairs = zip(stood, ways_m, strict=True)
            all_stood = all(one for one, ways in pairs if ways[direction] < way_m + AWAY_M)
            reported_m = standing.update(
                way_m, all_stood, walks, self._movers.turned_deg, view.acquired_s
            )
            least[direction] = min(least[direction], reported_m)
        if walks:
            contacts = self._sweeps.contacts(coming)
            least = np.minimum(least, contacts.min(axis=0))
            self.arcs = np.minimum(self.arcs, self._arcs.least(coming, contacts))
        return (float(least[0]), float(least[1]), float(least[2]), float(least[3]))

    def _bent(self, seen: Surfaces, doubted: IntArray, straight_m: float) -> float:
        # A bend no shorter than the straight way limits nothing.
        range_m = min(self._bend_m, max(0.0, straight_m - self._margin_m) + _ROUNDING_M)
        # These points are beside the body: the board's margin behind it is not needed as well.
        ways = self._sweeps.bent(seen.points_m, range_m) + self._margin_m
        if len(doubted):
            far = ways[doubted]
            ways[doubted] = np.where(far > self._zone.far[codes.DIR_BACKWARD], np.inf, far)
        least = float(ways.min())
        return math.inf if least > self._bend_m else least

    def _persons(self, seen: Surfaces) -> list[IntArray]:
        # Only what is straight ahead: a door post beside the path is as wide as a leg.
        low_m, high_m = self._across_m
        across_m = seen.points_m[:, 1]
        in_way = (across_m > low_m) & (across_m < high_m)
        return [
            thing[in_way[thing]]
            for thing in like_persons(seen, in_way)
            if not _is_askew(seen, thing)
            and not any(goes_on(seen.points_m[thing], other) for other in self._others)
        ]

    def _arcs_of(self, seen: Surfaces, contacts: FloatArray, at_s: float) -> ByteArray:
        # As for straight motions, a single beam beyond the zone does not count yet.
        lone = (seen.lone & (seen.ranges_m < _ARC_RANGE_M)).nonzero()[0]
        doubted = lone[~self._arc_speckles.again(seen.points_m[lone], at_s)]
        least = self._arcs.least(seen.points_m, contacts, doubted)
        if not len(doubted):
            return least
        ways = self._arcs.ways(seen.points_m[doubted], contacts[doubted])
        ways[ways > self._arc_zone] = arcs.FAR
        return np.asarray(np.minimum(least, ways.min(axis=0)), dtype=np.uint8)


def _is_askew(seen: Surfaces, thing: IntArray) -> bool:
    """Whether a thing lies between a nearer and a farther beam, in line with both."""
    first, last = int(thing[0]), int(thing[-1])
    before, after = first - 1, (last + 1) % len(seen.points_m)
    ranges_m = seen.ranges_m
    steps_m = ranges_m[first] - ranges_m[before], ranges_m[after] - ranges_m[last]
    if ranges_m[last] < ranges_m[first]:
        steps_m = -steps_m[0], -steps_m[1]
    if min(steps_m) < APART_M:  # no step: a gap between beams
        return False
    return askew(seen.points_m[thing], seen.points_m[before], seen.points_m[after])


class _Speckles:
    """Remembers the isolated returns of the last turn."""

    def __init__(self) -> None:
        self._kept: list[tuple[float, FloatArray]] = []

    def again(self, points: FloatArray, at_s: float) -> BoolArray:
        """Which of `points` had one near them a turn before; remembers `points`."""
        kept = [(s, p) for s, p in self._kept if 0.0 <= at_s - s <= _TURN_S[1]]
        self._kept = [*kept, (at_s, points)] if len(points) else kept
        before = [p for s, p in kept if at_s - s >= _TURN_S[0]]
        if not before or not len(points):
            return np.zeros(len(points), dtype=np.bool_)
        x, y = points.T[:, :, None] - np.concatenate(before).T[:, None, :]
        return np.asarray((np.hypot(x, y) < _SAME_PLACE_M).any(axis=1))
