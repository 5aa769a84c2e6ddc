"""How far each motion may go until the footprint touches a point: exact, for many points at once.

Here the chair stands still and the points move: in a forward motion they come straight towards it,
in a turn about the drive axle they circle in the opposite direction.

A point outside the grown footprint is touched when its path first enters it. A point already
within the margin (something came close, or the chair was pushed) does not block a motion that leads
away from it, and does not permit contact: if its path leads into the bare body before it leaves the
margin, only the distance to the body is left; if it leads out, only its return counts. For a point
within the bare body itself (a hand, a bag) a motion that takes the point deeper has clearance 0.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.angles import in_turn
from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.base.footprint import Footprint, distance_m, inside
from gazelink import codes

RANGE_M = 6.0
"""Straight distances longer than this count as free."""
HEADING_TOLERANCE_DEG = 1.0
"""The real path may differ from straight ahead by this: veer, casters, a heading that swings.
Obstacles already alongside are covered by the side margin, and backward by `Sweeps.bent`."""
BEND_PER_M = 0.2
"""Radians per metre by which a path meant to be straight may bend: wheels that differ by 10 %."""

_SEEN_M = 0.01  # an edge may be this much nearer than its smoothed points
_APART_M = 0.001
_FULL_TURN = 2.0 * math.pi
_PROBE_M = 0.005
_PROBE_RAD = 0.01
_DEEPER = 0.2  # share of the probe: sliding along the body is not deeper

_BOTH = np.array((1.0, -1.0))[:, None, None]  # left and right


class Sweeps:
    """The four motions of one footprint."""

    def __init__(self, footprint: Footprint) -> None:
        self._footprint = footprint
        body = footprint.body
        sides = np.concatenate([_sides(part) for part in footprint.parts])
        every = np.concatenate((sides, _sides(body)))
        self._circles = _Circles(sides)
        self._every_circles = _Circles(every)
        # To the left and to the right, relative to the centre of the bend.
        middles = [(0.0, side / BEND_PER_M) * 2 for side in (1.0, -1.0)]
        self._bends = _Circles(np.stack([_sides(body) - middle for middle in middles]))
        self._spread = math.tan(math.radians(HEADING_TOLERANCE_DEG))
        corners = np.concatenate(footprint.parts)
        self._ends_m = {sign: float((sign * corners[:, 0]).max()) for sign in (1.0, -1.0)}
        self._entries = {sign: _entries(sides, sign) for sign in (1.0, -1.0)}
        self._exits = {sign: _Rays(every, -sign, 0.0) for sign in (1.0, -1.0)}
        self._low, self._high = body.min(axis=0).tolist(), body.max(axis=0).tolist()

    def contacts(self, points_m: FloatArray) -> FloatArray:
        """(N, 4) for the (N, 2) points in the chair's frame, columns codes.DIR_FORWARD ...

        Metres for forward and backward, degrees for left and right; inf = never within RANGE_M, or
        within a full turn.
        """
        found = np.full((4, len(points_m)), np.inf).T  # one motion's values are contiguous
        reach_m, width_m = self._footprint.reach_m, self._footprint.half_width_m
        x, y = points_m[:, 0], np.abs(points_m[:, 1])
        # Only the few points that are near or in the widest corridor are computed exactly.
        near = ((np.abs(x) < reach_m + _APART_M) & (y < reach_m + _APART_M)).nonzero()[0]
        corridor = y <= width_m + self._spread * (RANGE_M + reach_m + reach_m)
        if len(near):
            around = _pick(points_m, near)
            reached = np.hypot(around[:, 0], around[:, 1]) <= reach_m
            grown = reached & self._footprint.contains(around)
            corridor[near[grown]] = False
            here = (reached & ~grown).nonzero()[0]
            if len(here):
                left, right = np.degrees(self._turns(_pick(around, here)))
                found[near.take(here), codes.DIR_LEFT] = left
                found[near.take(here), codes.DIR_RIGHT] = right
            here = grown.nonzero()[0]
            if len(here):
                found[near.take(here)] = self._from_within(_pick(around, here))
        chosen = corridor.nonzero()[0]
        ahead = _pick(points_m, chosen)
        aside_m = width_m + self._spread * (np.abs(ahead[:, 0]) + reach_m)
        straight = np.abs(ahead[:, 1]) <= aside_m
        for direction, sign in ((codes.DIR_FORWARD, 1.0), (codes.DIR_BACKWARD, -1.0)):
            way = sign * ahead[:, 0]
            here = (straight & (way > -reach_m) & (way < RANGE_M + reach_m)).nonzero()[0]
            if len(here):
                ways_m = self._straight(_pick(ahead, here), sign)
                found[chosen.take(here), direction] = ways_m
        return found

    def bent(self, points_m: FloatArray, range_m: float) -> FloatArray:
        """(N,): metres backward until the bare body touches each point on a path that bends.

        The shorter of a left and a right bend; inf = none within `range_m`, or a point within the
        body. Not needed forward, where the board holds the heading.
        """
        found = np.full(len(points_m), np.inf)
        reach_m = self._footprint.reach_m
        range_m = min(range_m, RANGE_M)
        swing_m = BEND_PER_M * range_m * (0.5 * range_m + reach_m) + _SEEN_M
        near = np.abs(points_m[:, 1]) <= self._footprint.half_width_m + swing_m
        # The body does not move ahead of its front.
        near &= (points_m[:, 0] <= self._ends_m[1.0]) & (points_m[:, 0] >= -reach_m - range_m)
        chosen = near.nonzero()[0]
        if not len(chosen):
            return found
        points = _pick(points_m, chosen)
        nearer_m = np.full(len(points), _SEEN_M)
        close = self._boxed(points, 2.0 * _SEEN_M)  # all others are farther from the body
        within = close[:0]
        if len(close):
            by = _pick(points, close)
            gap_m = np.maximum(distance_m(self._footprint.body, by) - _APART_M, 0.0)
            nearer_m[close] = np.minimum(gap_m, _SEEN_M)
            within = close[inside(self._footprint.body, by)]
        x, y = points[:, 0], points[:, 1] - np.sign(points[:, 1]) * nearer_m
        radius_m = 1.0 / BEND_PER_M
        aside = y - _BOTH * radius_m
        crossings, real = self._bends.crossings(x**2 + aside**2)
        turns = _BOTH * (crossings - np.arctan2(aside, x))
        ways_m = radius_m * _least(turns, real)
        ways_m[ways_m > range_m] = np.inf
        ways_m[within] = np.inf
        found[chosen] = ways_m
        return found

    def alongside(self, points_m: FloatArray) -> BoolArray:
        """Which of the (N, 2) points are within the side margin: neither ahead nor behind."""
        found = np.zeros(len(points_m), dtype=np.bool_)
        chosen = (np.abs(points_m[:, 1]) <= self._footprint.half_width_m).nonzero()[0]
        x = points_m[:, 0].take(chosen)
        chosen = chosen.compress((x > self._low[0]) & (x < self._high[0]))
        if len(chosen):
            near = _pick(points_m, chosen)
            found[chosen] = self._footprint.contains(near) & ~inside(self._footprint.body, near)
        return found

    def _boxed(self, points: FloatArray, more_m: float) -> IntArray:
        """Which points are within the body's box grown by `more_m`."""
        x, y = points[:, 0], points[:, 1]
        boxed = (x > self._low[0] - more_m) & (x < self._high[0] + more_m)
        boxed &= (y > self._low[1] - more_m) & (y < self._high[1] + more_m)
        return np.asarray(boxed.nonzero()[0])

    def _straight(self, points: FloatArray, sign: float) -> FloatArray:
        rays, oblique = self._entries[sign]
        ways = rays.crossings(points)
        beside = sign * points[:, 0] <= self._ends_m[sign]
        ways[oblique & beside] = np.inf
        nearest = ways.min(axis=0)
        nearest[nearest > RANGE_M] = np.inf
        return np.asarray(nearest)

    def _turns(self, points: FloatArray) -> FloatArray:
        # Rows left, right: when the chair turns left, the point's own angle decreases.
        own = np.arctan2(points[:, 1], points[:, 0])
        crossings, real = self._circles.crossings(points[:, 0] ** 2 + points[:, 1] ** 2)
        return np.stack((_least(own - crossings, real), _least(crossings - own, real)))

    def _from_within(self, points: FloatArray) -> FloatArray:
        # All motions in the same arrays, the straight ones first: many small arrays take longer.
        count = len(points)
        squared = points[:, 0] ** 2 + points[:, 1] ** 2
        paths = _Paths(points)
        crossings, real = self._every_circles.crossings(squared)
        turned = paths.own - crossings
        ways = np.full((crossings.shape[0] * crossings.shape[1], 4 * count), np.inf)
        for at, sign in enumerate((1.0, -1.0)):
            exits = self._exits[sign].crossings(points)
            ways[: len(exits), at * count : (at + 1) * count] = exits
            turns = np.where(real, in_turn(sign * turned, _FULL_TURN), np.inf)
            ways[:, (at + 2) * count : (at + 3) * count] = turns.reshape(-1, count)
        began = inside(self._footprint.body, points)
        ends = np.repeat((RANGE_M, _FULL_TURN), 2 * count)
        found = self._after_leaving(np.tile(began, 4), ways, ends, paths).reshape(4, -1).T
        if np.count_nonzero(began):
            at_first = began.nonzero()[0]
            which = np.concatenate([at_first + motion * count for motion in range(4)])
            probes = np.repeat((_PROBE_M, _PROBE_RAD), 2 * len(at_first))
            steps = paths.places(which, probes).reshape(4, -1, 2).transpose(1, 0, 2)
            deeper = self._deeper(points[at_first], steps)
            found[at_first] = np.where(deeper, 0.0, found[at_first])
        found[:, codes.DIR_LEFT :] = np.degrees(found[:, codes.DIR_LEFT :])
        return found

    def _deeper(self, points: FloatArray, steps: FloatArray) -> BoolArray:
        """(N, 4): which of the (N, 4, 2) first steps lead the (N, 2) points deeper into it."""
        outline = self._footprint.body
        before_m = distance_m(outline, points)[:, None]
        deeper_m = distance_m(outline, steps.reshape(-1, 2)).reshape(-1, 4) - before_m
        way = steps - points[:, None, :]
        return np.asarray(deeper_m > _DEEPER * np.hypot(way[..., 0], way[..., 1]))

    def _after_leaving(
        self, began: BoolArray, ways: FloatArray, ends: FloatArray, paths: _Paths
    ) -> FloatArray:
        """The way along each path to its contact. `began`: of points within the body; `ways`:
        (S, M) to crossings, at most `ends` count."""
        # Cut each path at its crossings; a piece between two cuts is entirely in or out.
        cuts = np.sort(np.minimum(ways, ends), axis=0)
        most = np.count_nonzero((cuts < ends).any(axis=1))
        cuts = np.concatenate((np.zeros((1, len(ends))), cuts[:most], ends[None]))
        real = cuts[1:] - cuts[:-1] > 1e-9
        # Most paths have few cuts: only real pieces are looked up.
        which, piece = real.T.nonzero()
        middles = paths.places(which, 0.5 * (cuts[piece, which] + cuts[piece + 1, which]))
        grown, body = np.zeros_like(real), np.zeros_like(real)
        grown[piece, which] = self._footprint.contains(middles)
        body[piece, which] = inside(self._footprint.body, middles)
        left = np.logical_or.accumulate(real & ~grown, axis=0)
        # A point that began within the body can touch it only after it has left it.
        free_of_body = np.logical_or.accumulate(real & ~body, axis=0) | ~began
        pressing = real & body & free_of_body & ~left
        touches = pressing | (real & grown & left)
        first = cuts[touches.argmax(axis=0), np.arange(len(ends))]
        return np.where(touches.any(axis=0), first, np.inf)


def _entries(sides: FloatArray, sign: float) -> tuple[_Rays, BoolArray]:
    """Rays to the sides where points can enter, and (S, 1): which are oblique by the tolerance."""
    found, motions = [], []
    for angle in (math.radians(k * HEADING_TOLERANCE_DEG) for k in (-1, 0, 1)):
        dx, dy = -sign * math.cos(angle), math.sin(angle)
        facing = sides[_facing(sides, dx, dy)]
        found.append(facing)
        motions += [(dx, dy)] * len(facing)
    moved = np.array(motions)
    rays = _Rays(np.concatenate(found), moved[:, :1], moved[:, 1:])
    return rays, moved[:, 1:] != 0.0


def _facing(sides: FloatArray, dx: float, dy: float) -> BoolArray:
    # Sides run counter-clockwise: a path enters where it has the inside on its other side.
    return np.asarray(dx * (sides[:, 3] - sides[:, 1]) - dy * (sides[:, 2] - sides[:, 0]) < 0.0)


def _pick(points: FloatArray, at: IntArray) -> FloatArray:
    """The (M, 2) points at these indices; as all points here, stored as a row of x and one of y."""
    return points.T.take(at, axis=1).T


def _sides(polygon: FloatArray) -> FloatArray:
    return np.concatenate((polygon, np.roll(polygon, -1, axis=0)), axis=1)


class _Paths:
    """Where (N, 2) points are on the paths of four motions: N of the first, N of the second ...

    Forward, backward, left, right; a way is in metres or radians.
    """

    _SIGNS = np.array((-1.0, 1.0, -1.0, 1.0))  # the points move against the chair

    def __init__(self, points: FloatArray) -> None:
        self._x, self._y = points[:, 0], points[:, 1]
        self._radius, self.own = np.hypot(self._x, self._y), np.arctan2(self._y, self._x)

    def places(self, which: IntArray, ways: FloatArray) -> FloatArray:
        """(M, 2): the places after `ways` (M,) along paths `which` (M,), ascending by motion."""
        count = len(self._x)
        moved = self._SIGNS.take(which // count) * ways
        at, turns = which % count, int(which.searchsorted(2 * count))
        found = np.empty((2, len(which)))
        found[0, :turns] = self._x.take(at[:turns]) + moved[:turns]
        found[1, :turns] = self._y.take(at[:turns])
        angle, radius = self.own.take(at[turns:]) + moved[turns:], self._radius.take(at[turns:])
        found[0, turns:] = radius * np.cos(angle)
        found[1, turns:] = radius * np.sin(angle)
        return found.T


def _least(turns: FloatArray, real: BoolArray) -> FloatArray:
    """(N,): each point's least real turn, wrapped to one turn; inf = none."""
    wrapped = np.where(real, in_turn(turns, _FULL_TURN), np.inf)
    least: FloatArray = wrapped.reshape(-1, turns.shape[-1]).min(axis=0)
    return least


class _Rays:
    """Straight motions along (dx, dy) to each of S sides; dx, dy: one for all, or (S, 1)."""

    def __init__(self, sides: FloatArray, dx: FloatArray | float, dy: FloatArray | float) -> None:
        self._ax, self._ay = sides[:, :1], sides[:, 1:2]
        self._ex, self._ey = sides[:, 2:3] - self._ax, sides[:, 3:] - self._ay
        self._dx, self._dy = dx, dy
        cross = dx * self._ey - dy * self._ex
        self._turned = np.abs(cross) > 1e-12
        self._inverse = np.where(self._turned, 1.0 / np.where(self._turned, cross, 1.0), 0.0)

    def crossings(self, points: FloatArray) -> FloatArray:
        """(S, N): the distance from each of the (N, 2) points to each side; inf = no crossing."""
        rx, ry = self._ax - points[:, 0], self._ay - points[:, 1]
        way = (rx * self._ey - ry * self._ex) * self._inverse
        share = (rx * self._dy - ry * self._dx) * self._inverse
        crosses = self._turned & (way >= 0.0) & (share >= -1e-9) & (share <= 1.0 + 1e-9)
        return np.where(crosses, way, np.inf)


class _Circles:
    """Circles about the origin through each of S sides; or, of each row of sides, about its own."""

    def __init__(self, sides: FloatArray) -> None:
        """`sides`: (S, 4) or (rows, S, 4)."""
        self._ax, self._ay = sides[..., :1], sides[..., 1:2]
        self._ex, self._ey = sides[..., 2:3] - self._ax, sides[..., 3:] - self._ay
        self._a = self._ex**2 + self._ey**2
        self._b = self._ax * self._ex + self._ay * self._ey
        self._b_squared, self._far = self._b**2, self._ax**2 + self._ay**2

    def crossings(self, squared_m: FloatArray) -> tuple[FloatArray, BoolArray]:
        """(2, S, N): the angles (radians) at which circles of these radii squared cross each side.

        And whether they do; where one does not, the angle means nothing. `squared_m`: (N,); or
        (rows, 1, N), and the result is (2, rows, S, N).
        """
        root = self._b_squared - self._a * (self._far - squared_m)
        spread = np.sqrt(np.maximum(root, 0.0))
        share = np.array((-spread, spread))
        share -= self._b
        share /= self._a
        real = (root >= 0.0) & (share >= -1e-9) & (share <= 1.0 + 1e-9)
        # Most circles miss most sides, and an arc tangent takes longer than all the rest.
        x, y = self._ax + share * self._ex, self._ay + share * self._ey
        return np.arctan2(y, x, out=np.zeros(real.shape), where=real), real
