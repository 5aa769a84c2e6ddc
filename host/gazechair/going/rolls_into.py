"""Into another path without a stop: a bend from where the chair rolls to, where it has room."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.going.bends import CLEAR_M, Bend, Point, bend_at, has_room
from gazechair.going.costmap import Costmap
from gazechair.going.path import Path
from gazechair.going.rolled import along
from gazechair.going.smooth import ALONG_M, TURN_M, Pose, turn_poses

_LEAST_RAD, _MOST_RAD = math.radians(5.0), math.radians(100.0)
_LEAST_RADIUS_M, _LEAST_TANGENT_M = 0.3, 0.05
_SHARPER = (1.0, 0.7, 0.5)  # shares of the radius at the present speed; it slows down for these
_STRAIGHT_AFTER_M = 0.3
_VERTICES = 2  # of the path, to which a bend may lead


@dataclass(frozen=True)
class Rolling:
    """How a chair rolls that could be steered now."""

    pose: Pose
    """Now."""
    begin: Pose
    """Where it turns as requested now, after dead time, ramp and lag."""
    speed_m_s: float
    turns_deg_s: float
    """How fast it still turns as requested before, left positive."""
    rate_rad_s: float
    """Highest turn rate of a bend."""
    stops_m: float
    """How far it rolls on if it brakes now."""


def rolled_into(costmap: Costmap, path: Path, rolling: Rolling) -> Path | None:
    """`path` with a bend into it in place of the turn before it; None: stop and turn.

    The bend leads to the path's first vertex, or past a first leg that is too short to the next.
    It must be as free as those of a plan, and the leg after it as free as the path.
    """
    if path.backward:
        return None
    for vertex in range(1, min(len(path.points_m), 1 + _VERTICES)):
        for radius_m in _radii_m(rolling):
            found = _into(costmap, path, vertex, rolling, radius_m)
            if found is not None:
                return found
    return None


def turns_rolling(costmap: Costmap, path: Path, rolling: Rolling) -> bool:
    """Whether the chair may turn to the path's first leg at once, while it still brakes.

    It may turn early or late on the way to its stop: at each place there any heading must be free.
    """
    a, b = path.points_m[:2]
    if path.backward or float(np.hypot(*(b - a))) < _STRAIGHT_AFTER_M:
        return False
    along_m = np.linspace(0.0, rolling.stops_m, max(2, int(rolling.stops_m / ALONG_M) + 1))
    return _turns_m(costmap, path, rolling, along_m) >= CLEAR_M


def turns_at_stop(costmap: Costmap, path: Path, rolling: Rolling) -> bool:
    """Whether the board will allow the turn to the path's first leg where the chair stops."""
    return _turns_m(costmap, path, rolling, np.array([rolling.stops_m])) >= TURN_M


def _turns_m(costmap: Costmap, path: Path, rolling: Rolling, along_m: FloatArray) -> float:
    """Least clearance in the turn to the first leg, at places `along_m` (N,) straight ahead.

    The chair aims at a point on the leg: the farther it rolls past that, the more it turns.
    """
    x, y, heading = rolling.pose
    stops = along(rolling.pose, rolling.stops_m, 0.0)
    aims = [path.aim_rad(0, pose) for pose in (rolling.pose, stops)]
    turns = [math.remainder(aim - heading, 2.0 * math.pi) for aim in aims if aim is not None]
    if len(turns) < len(aims):
        return -math.inf  # it rolls past the leg: which turn comes next is not known
    _, _, turned = turn_poses(rolling.pose, heading + max(turns, key=abs))
    at = np.array((x, y)) + along_m[:, None] * (math.cos(heading), math.sin(heading))
    return float(costmap.clearance_m(at[:, :1], at[:, 1:], turned[None, :]).min())


def _radii_m(rolling: Rolling) -> list[float]:
    """Radii to try, the widest first: the least at the chair's speed, and sharper ones."""
    least_m = rolling.speed_m_s / rolling.rate_rad_s
    return sorted({max(_LEAST_RADIUS_M, share * least_m) for share in _SHARPER}, reverse=True)


def _into(
    costmap: Costmap, path: Path, vertex: int, rolling: Rolling, radius_m: float
) -> Path | None:
    """The path from its `vertex` on, and a bend to it."""
    end = _point(path, vertex)
    bend = _bend(rolling, end, radius_m)
    if bend is None:
        return None
    x, y, heading = rolling.begin
    corner = x + bend.tangent_m * math.cos(heading), y + bend.tangent_m * math.sin(heading)
    after = path.bend(vertex)
    left_m = math.dist(corner, end) - bend.tangent_m
    left_m -= _STRAIGHT_AFTER_M if after is None else after.tangent_m
    if left_m < 0.0 or not has_room(costmap, bend):
        return None
    if after is not None:
        after = bend_at(costmap, corner, end, _point(path, vertex + 1), after.tangent_m)
        if after is None:
            return None
    if not _is_free(costmap, rolling.pose, bend, corner, end, min(CLEAR_M, path.clearance_m)):
        return None
    points = np.array([rolling.pose[:2], corner, *path.points_m[vertex:]])
    bends = (None, bend, after, *path.bends[vertex + 1 :])
    first, second = path.points_m[:2]
    began_rad = math.atan2(second[1] - first[1], second[0] - first[0])
    return replace(path, points_m=points, bends=bends, began_rad=began_rad)


def _bend(rolling: Rolling, end: Point, radius_m: float) -> Bend | None:
    """From where the chair turns, and straight on to `end`; None: too little or too much turn."""
    x, y, heading = rolling.begin
    c, s = math.cos(heading), math.sin(heading)
    ahead, left = c * (end[0] - x) + s * (end[1] - y), c * (end[1] - y) - s * (end[0] - x)
    gap_m = math.hypot(ahead, abs(left) - radius_m)
    if rolling.turns_deg_s * left < 0.0 or gap_m <= radius_m:
        return None
    # The tangent from `end` to the circle, seen from its centre.
    angle = math.acos(-radius_m / gap_m) - math.atan2(ahead, abs(left) - radius_m)
    angle %= 2.0 * math.pi
    if not _LEAST_RAD < angle < _MOST_RAD:
        return None
    tangent_m = max(_LEAST_TANGENT_M, radius_m * math.tan(0.5 * angle))
    return Bend.of((x, y), (x + tangent_m * c, y + tangent_m * s), end, tangent_m)


def _is_free(
    costmap: Costmap, pose: Pose, bend: Bend, corner: Point, end: Point, least_m: float
) -> bool:
    """Whether `least_m` is clear before and after the bend, and nobody may stand after it."""
    heading = math.atan2(end[1] - corner[1], end[0] - corner[0])
    share = bend.tangent_m / math.dist(corner, end)
    leaves = corner[0] + share * (end[0] - corner[0]), corner[1] + share * (end[1] - corner[1])
    for a, b, rad in ((pose[:2], bend.begin_m, pose[2]), (leaves, end, heading)):
        count = max(2, int(math.dist(a, b) / ALONG_M) + 1)
        at = np.linspace(a, b, count)
        if float(costmap.clearance_m(at[:, 0], at[:, 1], rad).min()) < least_m:
            return False
    return costmap.ahead.leg_s(costmap.standing_m, np.array(leaves), np.array(end), False) == 0.0


def _point(path: Path, vertex: int) -> Point:
    x, y = path.points_m[vertex]
    return float(x), float(y)
