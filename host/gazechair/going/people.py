"""Tracks people who walk, as things that are not in the map, and predicts them 2 seconds ahead."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.base.footprint import Footprint
from gazechair.going.outline import outline

AHEAD_S = 2.0
_APART_M = 0.35
_LARGEST_M = 1.0
_SAME_M = 0.45
_FORGET_S = 0.6
_LEAST_POINTS = 3
_WALKS_M_S = 0.2
_MOST_M_S = 1.6
_BLEND = 0.35
_SURE = 4  # looks before it counts
_CAME_M = 0.2  # least distance moved: parts of things that come into view seem to move, too
_LEFT_M = 0.15
_BODY_M = 0.25
_SPACE_M = 0.35
"""Between the chair and a person who walks."""
_BRAKE_M_S2 = 0.3
_STEP_S = 0.25


@dataclass
class Track:
    """One thing that is not in the map; position and velocity in the map's frame."""

    x_m: float
    y_m: float
    vx_m_s: float
    vy_m_s: float
    seen_s: float
    looks: int = 1
    from_m: tuple[float, float] | None = None
    """Where it was seen first."""
    left: bool = False
    """Whether nothing is seen at `from_m` any more."""

    @property
    def walks(self) -> bool:
        """Whether it has moved far and fast enough to count as walking."""
        if self.from_m is None or math.dist(self.from_m, (self.x_m, self.y_m)) < _CAME_M:
            return False
        if not self.left:  # perhaps another part of the same thing
            return False
        return self.looks >= _SURE and math.hypot(self.vx_m_s, self.vy_m_s) > _WALKS_M_S


class People:
    """Tracks them; feed it the returns that the map does not explain, in the map's frame."""

    def __init__(self) -> None:
        self.tracks: list[Track] = []

    def look(self, points_m: FloatArray, at_s: float) -> None:
        """Take in one scan's points (N, 2), in the order of the scan."""
        self.tracks = [one for one in self.tracks if at_s - one.seen_s < _FORGET_S]
        free = list(self.tracks)
        for x, y in _things(points_m):

            def gap(one: Track, x: float = x, y: float = y) -> float:
                dt = at_s - one.seen_s
                return math.hypot(one.x_m + one.vx_m_s * dt - x, one.y_m + one.vy_m_s * dt - y)

            best = min(free, key=gap, default=None)
            if best is None or gap(best) > _SAME_M:
                self.tracks.append(Track(x, y, 0.0, 0.0, at_s, from_m=(x, y)))
                continue
            free.remove(best)
            dt = at_s - best.seen_s
            if dt <= 0.0:
                continue
            vx, vy = (x - best.x_m) / dt, (y - best.y_m) / dt
            size = math.hypot(vx, vy)
            if size > _MOST_M_S:
                vx, vy = vx * _MOST_M_S / size, vy * _MOST_M_S / size
            best.vx_m_s += _BLEND * (vx - best.vx_m_s)
            best.vy_m_s += _BLEND * (vy - best.vy_m_s)
            best.x_m, best.y_m, best.seen_s = x, y, at_s
            best.looks += 1
        for one in self.tracks:
            if one.from_m is not None:
                off_m = np.hypot(points_m[:, 0] - one.from_m[0], points_m[:, 1] - one.from_m[1])
                one.left = bool(off_m.min(initial=math.inf) > _LEFT_M)

    def free_m(self, poses: FloatArray, footprint: Footprint) -> float:
        """Metres along `poses` (N, 4: x, y, heading, metres) without walkers near within 2 s."""
        walkers = [one for one in self.tracks if one.walks]
        if not walkers or not len(poses):
            return math.inf
        times = np.arange(0.0, AHEAD_S + 0.01, _STEP_S)
        corners = np.concatenate(outline(footprint))
        low, high = corners.min(axis=0), corners.max(axis=0)
        c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
        least = math.inf
        for one in walkers:
            dx = one.x_m + one.vx_m_s * times[None, :] - poses[:, 0][:, None]
            dy = one.y_m + one.vy_m_s * times[None, :] - poses[:, 1][:, None]
            ahead, left = c * dx + s * dy, c * dy - s * dx
            gx = np.maximum(np.maximum(low[0] - ahead, ahead - high[0]), 0.0)
            gy = np.maximum(np.maximum(low[1] - left, left - high[1]), 0.0)
            near: BoolArray = (np.hypot(gx, gy) < _BODY_M + _SPACE_M).any(axis=1)
            if near.any():
                least = min(least, float(poses[near, 3].min()))
        return least


def speed_within(free_m: float) -> float:
    """Highest speed from which the chair stops gently within `free_m`."""
    return math.inf if math.isinf(free_m) else math.sqrt(2.0 * _BRAKE_M_S2 * max(0.0, free_m - 0.1))


def _things(points_m: FloatArray) -> Iterable[tuple[float, float]]:
    """Centres of what may be a person: points close together, in the order of the scan."""
    if len(points_m) < _LEAST_POINTS:
        return []
    gaps = np.hypot(*np.diff(points_m, axis=0).T)
    cuts = np.flatnonzero(gaps > _APART_M) + 1
    found = []
    for part in np.split(points_m, cuts):
        size = part.max(axis=0) - part.min(axis=0)
        if len(part) >= _LEAST_POINTS and float(size.max()) <= _LARGEST_M:
            found.append((float(part[:, 0].mean()), float(part[:, 1].mean())))
    return found
