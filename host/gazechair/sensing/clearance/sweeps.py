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
from collections.abc import Callable

import numpy as np

from gazechair.base.footprint import BoolArray, FloatArray, Footprint, distance_m, inside
from gazelink import codes

RANGE_M = 6.0
"""Straight distances longer than this count as free."""
HEADING_TOLERANCE_DEG = 1.0
"""The real path may differ from straight ahead by this: veer, casters, a heading that swings.
For obstacles already alongside the side margin covers that, and backward `Sweeps.bent`."""
BEND_PER_M = 0.2
"""Radians a metre by which a path meant to be straight may bend: wheels that differ by a tenth."""

_SEEN_M = 0.01  # an edge may be so much nearer than its smoothed points are
_APART_M = 0.001
_FULL_TURN = 2.0 * math.pi
_PROBE_M = 0.005
_PROBE_RAD = 0.01
_DEEPER = 0.2  # of the probe: sliding along is not pressing

Path = Callable[[FloatArray], FloatArray]


class Sweeps:
    """The four motions of one footprint."""

    def __init__(self, footprint: Footprint) -> None:
        self._footprint = footprint
        grown = [_sides(part) for part in footprint.parts]
        self._sides = np.concatenate(grown)
        self._bare = _sides(footprint.body)
        self._every = np.concatenate((self._sides, self._bare))
        self._spread = math.tan(math.radians(HEADING_TOLERANCE_DEG))
        every = np.concatenate(footprint.parts)
        self._ends_m = {sign: float((sign * every[:, 0]).max()) for sign in (1.0, -1.0)}
        self._entries = {sign: _entries(self._sides, sign) for sign in (1.0, -1.0)}

    def contacts(self, points_m: FloatArray) -> FloatArray:
        """(N, 4) for the (N, 2) points in the chair's frame, columns codes.DIR_FORWARD ...

        Metres for forward and backward, degrees for left and right; inf = never within RANGE_M, or
        within a full turn.
        """
        found = np.full((4, len(points_m)), np.inf).T  # a motion's values side by side
        near = np.flatnonzero(np.hypot(points_m[:, 0], points_m[:, 1]) <= self._footprint.reach_m)
        within = near[self._footprint.contains(points_m[near])]
        out = np.ones(len(points_m), dtype=np.bool_)
        out[within] = False
        x, y = points_m[:, 0], points_m[:, 1]
        reach_m = self._footprint.reach_m
        aside_m = self._footprint.half_width_m + self._spread * (np.abs(x) + reach_m)
        corridor = out & (np.abs(y) <= aside_m)
        for direction, sign in ((codes.DIR_FORWARD, 1.0), (codes.DIR_BACKWARD, -1.0)):
            ahead = (sign * x > -reach_m) & (sign * x < RANGE_M + reach_m)
            chosen = np.flatnonzero(corridor & ahead)
            found[chosen, direction] = self._straight(points_m[chosen], sign)
        around = near[out[near]]
        found[around, codes.DIR_LEFT :] = np.degrees(self._turns(points_m[around]))
        if len(within):
            found[within] = self._from_within(points_m[within])
        return found

    def bent(self, points_m: FloatArray, range_m: float) -> FloatArray:
        """(N,): metres backward until a bending path takes the bare body there.

        Whichever side it bends to; inf = never within `range_m`, or within the body already.
        Forward the board holds the heading.
        """
        found = np.full(len(points_m), np.inf)
        reach_m = self._footprint.reach_m
        range_m = min(range_m, RANGE_M)
        swing_m = BEND_PER_M * range_m * (0.5 * range_m + reach_m) + _SEEN_M
        near = np.abs(points_m[:, 1]) <= self._footprint.half_width_m + swing_m
        # Nothing of the body moves ahead meanwhile.
        near &= (points_m[:, 0] <= self._ends_m[1.0]) & (points_m[:, 0] >= -reach_m - range_m)
        chosen = np.flatnonzero(near)
        chosen = chosen[~inside(self._footprint.body, points_m[chosen])]
        nearest = points_m[chosen]
        gap_m = np.maximum(distance_m(self._footprint.body, nearest) - _APART_M, 0.0)
        nearest = np.column_stack(
            (nearest[:, 0], nearest[:, 1] - np.sign(nearest[:, 1]) * np.minimum(gap_m, _SEEN_M))
        )
        radius_m = 1.0 / BEND_PER_M
        for side in (1.0, -1.0):
            # About the middle of the bend, the body's points and the obstacle's.
            middle = np.array((0.0, side * radius_m))
            points = nearest - middle
            own = np.arctan2(points[:, 1], points[:, 0])
            crossings = _circle_crossings(points, self._bare - np.tile(middle, 2))
            turns = _least(side * (crossings - own) % _FULL_TURN)
            found[chosen] = np.minimum(found[chosen], radius_m * turns)
        found[found > range_m] = np.inf
        return found

    def alongside(self, points_m: FloatArray) -> BoolArray:
        """Which of the (N, 2) points are within the side margin: neither ahead nor behind."""
        body = self._footprint.body
        low, high = body[:, 0].min(), body[:, 0].max()
        found = (points_m[:, 0] > low) & (points_m[:, 0] < high)
        found &= np.abs(points_m[:, 1]) <= self._footprint.half_width_m
        chosen = np.flatnonzero(found)
        near = points_m[chosen]
        found[chosen] = self._footprint.contains(near) & ~inside(body, near)
        return np.asarray(found)

    def _straight(self, points: FloatArray, sign: float) -> FloatArray:
        if not len(points):
            return np.zeros(0)
        sides, dx, dy = self._entries[sign]
        ways = _ray_crossings(points, sides, dx, dy)
        beside = sign * points[:, 0] <= self._ends_m[sign]
        ways[(dy != 0.0) & beside] = np.inf
        nearest = ways.min(axis=0)
        nearest[nearest > RANGE_M] = np.inf
        return np.asarray(nearest)

    def _turns(self, points: FloatArray) -> FloatArray:
        # Columns left, right: when the chair turns left, the point's own angle decreases.
        own = np.arctan2(points[:, 1], points[:, 0])
        crossings = _circle_crossings(points, self._sides)
        left, right = _least((own - crossings) % _FULL_TURN), _least((crossings - own) % _FULL_TURN)
        return np.column_stack((left, right))

    def _from_within(self, points: FloatArray) -> FloatArray:
        found = np.empty((len(points), 4))
        for direction, sign in ((codes.DIR_FORWARD, 1.0), (codes.DIR_BACKWARD, -1.0)):
            ways = _ray_crossings(points, self._every, -sign, 0.0)
            found[:, direction] = self._after_leaving(
                points, ways, RANGE_M, _PROBE_M, _line(points, -sign)
            )
        own = np.arctan2(points[:, 1], points[:, 0])
        crossings = _circle_crossings(points, self._every)
        for direction, sign in ((codes.DIR_LEFT, 1.0), (codes.DIR_RIGHT, -1.0)):
            ways = np.nan_to_num(sign * (own - crossings) % _FULL_TURN, nan=np.inf)
            found[:, direction] = np.degrees(
                self._after_leaving(points, ways, _FULL_TURN, _PROBE_RAD, _circle(points, -sign))
            )
        return found

    def _after_leaving(
        self, points: FloatArray, ways: FloatArray, end: float, probe: float, path: Path
    ) -> FloatArray:
        # Cut each path at its crossings; a piece between two cuts is entirely in or out.
        count = len(points)
        cuts = np.sort(np.minimum(ways.T, end), axis=1)
        cuts = np.concatenate((np.zeros((count, 1)), cuts, np.full((count, 1), end)), axis=1)
        middles = path(0.5 * (cuts[:, :-1] + cuts[:, 1:])).reshape(-1, 2)
        shape = (count, cuts.shape[1] - 1)
        real = cuts[:, 1:] - cuts[:, :-1] > 1e-9
        grown = self._footprint.contains(middles).reshape(shape)
        body = inside(self._footprint.body, middles).reshape(shape)
        left = np.logical_or.accumulate(real & ~grown, axis=1)
        # A point that began within the body can touch it only after it has left it.
        began = inside(self._footprint.body, points)
        free_of_body = np.logical_or.accumulate(real & ~body, axis=1) | ~began[:, None]
        pressing = real & body & free_of_body & ~left
        step = path(np.full((count, 1), probe))[:, 0, :]
        outline = self._footprint.body
        deeper_m = distance_m(outline, step) - distance_m(outline, points)
        deeper = began & (deeper_m > _DEEPER * np.hypot(*(step - points).T))
        touches = pressing | (real & grown & left)
        first = cuts[np.arange(count), touches.argmax(axis=1)]
        return np.where(deeper, 0.0, np.where(touches.any(axis=1), first, np.inf))


def _entries(sides: FloatArray, sign: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The sides through which the points can enter, and beside each their motion (dx, dy)."""
    found, motions = [], []
    for angle in (math.radians(k * HEADING_TOLERANCE_DEG) for k in (-1, 0, 1)):
        dx, dy = -sign * math.cos(angle), math.sin(angle)
        facing = sides[_facing(sides, dx, dy)]
        found.append(facing)
        motions += [(dx, dy)] * len(facing)
    moved = np.array(motions)
    return np.concatenate(found), moved[:, :1], moved[:, 1:]


def _facing(sides: FloatArray, dx: float, dy: float) -> BoolArray:
    # Sides run counter-clockwise: a path enters where it has the inside on its other side.
    return np.asarray(dx * (sides[:, 3] - sides[:, 1]) - dy * (sides[:, 2] - sides[:, 0]) < 0.0)


def _sides(polygon: FloatArray) -> FloatArray:
    return np.concatenate((polygon, np.roll(polygon, -1, axis=0)), axis=1)


def _line(points: FloatArray, sign: float) -> Path:
    def at(ways: FloatArray) -> FloatArray:
        return np.stack((points[:, :1] + sign * ways, points[:, 1:] + 0.0 * ways), axis=2)

    return at


def _circle(points: FloatArray, sign: float) -> Path:
    radius = np.hypot(points[:, 0], points[:, 1])[:, None]
    own = np.arctan2(points[:, 1], points[:, 0])[:, None]

    def at(ways: FloatArray) -> FloatArray:
        angle = own + sign * ways
        return np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=2)

    return at


def _least(turns: FloatArray) -> FloatArray:
    """(N,): the least of each column, of those that there are; inf = none."""
    least: FloatArray = np.fmin.reduce(turns, axis=0)
    return np.where(np.isnan(least), np.inf, least)


def _ray_crossings(
    points: FloatArray, sides: FloatArray, dx: FloatArray | float, dy: FloatArray | float
) -> FloatArray:
    """(S, N): the distance along (dx, dy) from each point to each side; inf = no crossing.

    `dx`, `dy`: one motion for all sides, or (S, 1).
    """
    ax, ay = sides[:, :1], sides[:, 1:2]
    ex, ey = sides[:, 2:3] - ax, sides[:, 3:] - ay
    cross = dx * ey - dy * ex
    turned = np.abs(cross) > 1e-12
    inverse = np.where(turned, 1.0 / np.where(turned, cross, 1.0), 0.0)
    rx, ry = ax - points[:, 0], ay - points[:, 1]
    way = (rx * ey - ry * ex) * inverse
    share = (rx * dy - ry * dx) * inverse
    crosses = turned & (way >= 0.0) & (share >= -1e-9) & (share <= 1.0 + 1e-9)
    return np.where(crosses, way, np.inf)


def _circle_crossings(points: FloatArray, sides: FloatArray) -> FloatArray:
    """(2 S, N): angles (radians) at which each point's circle about the axle crosses each side."""
    ax, ay = sides[:, :1], sides[:, 1:2]
    ex, ey = sides[:, 2:3] - ax, sides[:, 3:] - ay
    squared = points[:, 0] ** 2 + points[:, 1] ** 2
    a = ex**2 + ey**2
    b = ax * ex + ay * ey
    root = b**2 - a * (ax**2 + ay**2 - squared)
    spread = np.sqrt(np.maximum(root, 0.0))
    share = np.stack((-b - spread, -b + spread)) / a
    crosses = (root >= 0.0) & (share >= -1e-9) & (share <= 1.0 + 1e-9)
    angles = np.where(crosses, np.arctan2(ay + share * ey, ax + share * ex), np.nan)
    return angles.reshape(2 * len(sides), len(points))
