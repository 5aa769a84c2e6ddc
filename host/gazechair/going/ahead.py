"""What lies ahead along the path: clearances, walkers' room, and the first obstacle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint
from gazechair.going.costmap import Costmap
from gazechair.going.people import People
from gazechair.going.plan import Path, Pose

_LOOK_AHEAD_M = 2.5
_ALONG_M = 0.1
_STRAIGHT_M = np.arange(0.0, 0.81, 0.1)
_HIT_M = -0.04  # with less clearance ahead, by map and lidars, the path is blocked
_BESIDE_M = 0.75  # clearance within this distance counts for steering
_WALKERS_M = 2.0


@dataclass(frozen=True)
class Ahead:
    """The view from one pose along the path."""

    room_m: float = 0.0
    """Least clearance along the next steps of the path."""
    straight_m: float = math.inf
    """Least clearance straight ahead; straight back while the path leads backward."""
    free_m: float = math.inf
    """Length of the path before the first walker's."""
    hit_m: float = math.inf
    """Distance to the first obstacle on the path; inf: none is near."""


def look_ahead(
    costmap: Costmap, people: People, footprint: Footprint, path: Path, leg: int, pose: Pose
) -> Ahead:
    """The view from `pose` along `path`, of which `leg` is driven."""
    poses = poses_ahead(path, leg, pose)
    clear = costmap.clearance_m(poses[:, 0], poses[:, 1], poses[:, 2])
    near = poses[:, 3] < _BESIDE_M
    along_m = -_STRAIGHT_M if path.backward and leg == 0 else _STRAIGHT_M
    onward = along_m[:, None] * (math.cos(pose[2]), math.sin(pose[2])) + pose[:2]
    straight = costmap.clearance_m(onward[:, 0], onward[:, 1], pose[2])
    hits_m = poses[1:, 3][clear[1:] < _HIT_M]
    return Ahead(
        float(clear[near].min()) if near.any() else 0.0,
        float(straight.min()),
        people.free_m(poses[poses[:, 3] < _WALKERS_M], footprint),
        float(hits_m.min(initial=math.inf)),
    )


def poses_ahead(path: Path, at_leg: int, pose: Pose) -> FloatArray:
    """Rows (N, 4): x, y, heading, metres ahead; the chair's own first. `at_leg`: current leg."""
    rows, done = [(*pose, 0.0)], 0.0
    begin = np.array(pose[:2])
    for leg in range(at_leg, len(path.points_m) - 1):
        bend = path.bend(leg + 1)
        end = path.points_m[leg + 1] if bend is None else np.array(bend.begin_m)
        for one in (
            *_straight(path, leg, begin, end),
            *(() if bend is None else bend.sampled()),
        ):
            done += math.dist(one[:2], rows[-1][:2])
            if done > _LOOK_AHEAD_M:
                return np.array(rows)
            rows.append((*one, done))
        begin = np.array(rows[-1][:2]) if bend is not None else end
    return np.array(rows)


def _straight(path: Path, leg: int, a: FloatArray, b: FloatArray) -> list[Pose]:
    """Poses between `a` and `b`; empty if they nearly coincide, or `a` is past the bend's begin."""
    onward = b - a
    length = float(np.hypot(*onward))
    along = path.points_m[leg + 1] - path.points_m[leg]
    if length < 0.02 or (path.bend(leg + 1) is not None and float(onward @ along) < 0.0):
        return []
    heading = math.atan2(onward[1], onward[0])
    if path.backward and leg == 0:
        heading += math.pi
    steps = np.arange(_ALONG_M, length, _ALONG_M) / length
    return [(float(x), float(y), heading) for x, y in a + steps[:, None] * onward]
