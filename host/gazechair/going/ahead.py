"""Poses along the next metres of the planned path."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.going.plan import Pose, Way

_LOOK_AHEAD_M = 2.5
_ALONG_M = 0.1


def poses_ahead(way: Way, at_leg: int, pose: Pose) -> FloatArray:
    """Rows (N, 4): x, y, heading, metres ahead; the chair's own first. `at_leg`: current leg."""
    rows, done = [(*pose, 0.0)], 0.0
    begin = np.array(pose[:2])
    for leg in range(at_leg, len(way.points_m) - 1):
        bend = way.bend(leg + 1)
        end = way.points_m[leg + 1] if bend is None else np.array(bend.begin_m)
        for one in (
            *_straight(way, leg, begin, end),
            *(() if bend is None else bend.sampled()),
        ):
            done += math.dist(one[:2], rows[-1][:2])
            if done > _LOOK_AHEAD_M:
                return np.array(rows)
            rows.append((*one, done))
        begin = np.array(rows[-1][:2]) if bend is not None else end
    return np.array(rows)


def _straight(way: Way, leg: int, a: FloatArray, b: FloatArray) -> list[Pose]:
    """Poses between `a` and `b`; empty if they nearly coincide, or `a` is past the bend's begin."""
    onward = b - a
    length = float(np.hypot(*onward))
    along = way.points_m[leg + 1] - way.points_m[leg]
    if length < 0.02 or (way.bend(leg + 1) is not None and float(onward @ along) < 0.0):
        return []
    heading = math.atan2(onward[1], onward[0])
    if way.backward and leg == 0:
        heading += math.pi
    steps = np.arange(_ALONG_M, length, _ALONG_M) / length
    return [(float(x), float(y), heading) for x, y in a + steps[:, None] * onward]
