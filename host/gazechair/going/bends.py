"""Bends: an arc in place of a vertex, driven without a stop where the board lets curves through.

Turning on the spot costs a stop, the turn and a start. An arc needs room: for itself, and for what
the board requires free when both axes move, as it does not know which axis responds first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.going.costmap import Costmap

RATE_RAD_S = math.radians(17.5)
"""Highest turn rate in a bend; fast enough for the board to verify the selected profile."""
LEAST_M, MOST_M = 0.12, 0.9
"""Shortest and longest tangent of a bend: from the vertex to either end of the arc."""
CLEAR_M = 0.10
"""Least clearance along the arc."""
_LEAST_RADIUS_M = 0.3
_NONE_RAD = math.radians(2.0)
_MOST_RAD = math.radians(125.0)
_SMALLER = 0.65
_TRIES = 3
_STEP_RAD, _STEP_M = math.radians(5.0), 0.08
# Room that the board requires beyond each pose: a further turn and straight travel, in any order.
_TURNS_ON_RAD, _TURNS_ON_S, _GOES_ON_M, _BEYOND_M = math.radians(4.0), 1.5, 0.50, 0.03
_SPEED_M_S, _SETTLES_S = 0.22, 0.6


Point = tuple[float, float]
"""x, y in metres, in the map's frame."""


@dataclass(frozen=True)
class Bend:
    """The arc between the legs from `a` to `b` and from `b` to `c`."""

    begin_m: Point
    begin_rad: float
    angle_rad: float
    """Left positive."""
    radius_m: float
    tangent_m: float

    @classmethod
    def of(cls, a: Point, b: Point, c: Point, tangent_m: float) -> Bend:
        """Tangent to both legs, beginning `tangent_m` before `b`."""
        x, y = b[0] - a[0], b[1] - a[1]
        begin_rad = math.atan2(y, x)
        angle = math.remainder(math.atan2(c[1] - b[1], c[0] - b[0]) - begin_rad, 2.0 * math.pi)
        share = tangent_m / math.hypot(x, y)
        begin = b[0] - x * share, b[1] - y * share
        radius = tangent_m / max(math.tan(0.5 * abs(angle)), 1e-6)
        return cls(begin, begin_rad, angle, radius, tangent_m)

    @property
    def is_none(self) -> bool:
        """Whether the angle is too small for an arc: the next leg is driven at once."""
        return abs(self.angle_rad) < _NONE_RAD

    @property
    def length_m(self) -> float:
        """Length of the arc."""
        return self.radius_m * abs(self.angle_rad)

    @property
    def curve_per_m(self) -> float:
        """Curvature in 1/m, left positive."""
        return math.copysign(1.0 / self.radius_m, self.angle_rad)

    def place(self, x_m: float, y_m: float) -> tuple[float, float]:
        """Radians that a point is along the arc, and metres that it is to the left of it."""
        side = math.copysign(1.0, self.angle_rad)
        c, s = math.cos(self.begin_rad), math.sin(self.begin_rad)
        dx, dy = x_m - self.begin_m[0], y_m - self.begin_m[1]
        along, across = c * dx + s * dy, side * (c * dy - s * dx)
        gap = math.hypot(along, self.radius_m - across)
        return math.atan2(along, self.radius_m - across), side * (self.radius_m - gap)

    def poses(self, turned_rad: FloatArray) -> FloatArray:
        """Poses (N, 3) after each angle `turned_rad` (N,) along the arc."""
        side = math.copysign(1.0, self.angle_rad)
        along = self.radius_m * np.sin(turned_rad)
        across = side * self.radius_m * (1.0 - np.cos(turned_rad))
        c, s = math.cos(self.begin_rad), math.sin(self.begin_rad)
        x = self.begin_m[0] + c * along - s * across
        y = self.begin_m[1] + s * along + c * across
        return np.stack((x, y, self.begin_rad + side * turned_rad), axis=1)

    def sampled(self) -> FloatArray:
        """Poses (N, 3) from its begin to its end."""
        step = min(_STEP_RAD, _STEP_M / self.radius_m)
        count = max(2, math.ceil(abs(self.angle_rad) / step) + 1)
        return self.poses(np.linspace(0.0, abs(self.angle_rad), count))

    @property
    def seconds(self) -> float:
        """Time in addition to driving both tangents at full speed, without a stop."""
        drives_s = max(abs(self.angle_rad) / RATE_RAD_S, self.length_m / _SPEED_M_S)
        return _SETTLES_S + drives_s - 2.0 * self.tangent_m / _SPEED_M_S


def widest(a: Point, b: Point, c: Point, most_m: float) -> Bend | None:
    """The widest bend at `b`, whether or not it has room; None: none is permitted.

    Of all bends there it takes the least time.
    """
    tangent_m = min(most_m, MOST_M)
    if tangent_m < LEAST_M:
        return None
    bend = Bend.of(a, b, c, tangent_m)
    return None if abs(bend.angle_rad) > _MOST_RAD or bend.radius_m < _LEAST_RADIUS_M else bend


def bend_at(costmap: Costmap, a: Point, b: Point, c: Point, most_m: float) -> Bend | None:
    """The widest bend at `b` that has room; None: turn on the spot."""
    for _ in range(_TRIES):
        bend = widest(a, b, c, most_m)
        if bend is None or bend.is_none or has_room(costmap, bend):
            return bend
        most_m = _SMALLER * bend.tangent_m
    return None


def has_room(costmap: Costmap, bend: Bend) -> bool:
    """Whether the arc is clear, and what the board wants free beyond it."""
    poses = bend.sampled()
    x, y, heading = poses.T
    if float(costmap.clearance_m(x, y, heading).min()) < CLEAR_M:
        return False
    rate = min(RATE_RAD_S, _SPEED_M_S / bend.radius_m)
    turned = heading + math.copysign(_TURNS_ON_RAD + _TURNS_ON_S * rate, bend.angle_rad)
    gone = [
        (x + _GOES_ON_M * np.cos(way), y + _GOES_ON_M * np.sin(way)) for way in (heading, turned)
    ]
    xs, ys = np.array((x, gone[0][0], gone[1][0])), np.array((y, gone[0][1], gone[1][1]))
    if float(costmap.clearance_m(xs, ys, turned[None, :]).min()) < _BEYOND_M:
        return False
    return not costmap.ahead.meets(costmap.standing_m, poses)
