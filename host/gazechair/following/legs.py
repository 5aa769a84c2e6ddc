"""Legs in a scan: clusters of foreground returns that are as wide as a leg, or as both together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray

FARTHEST_M = 5.5
_MOST = 60
"""Clusters used of one scan, the nearest: bounds the cost of a scan."""
_GAP_M, _GAP_PER_M = 0.09, 0.012
_LEAST_POINTS, _LEAST_FAR_POINTS = 3, 2
_FAR_M = 3.5
_THIN_M, _LEG_M = 0.05, 0.23  # thinner: a cane or a chair's leg
_PERSON_M = 0.62
_NEARER_M = 0.10
_BEHIND_SHARE = 0.35  # of the width: the middle lies behind the visible side
_BEHIND_MOST_M = 0.15
LEGS_APART_M = 0.55
"""The legs of one person are at most this far from each other."""
_SAME_M = 0.20  # how far a leg moves from one scan to the next


@dataclass(frozen=True)
class Scan:
    """One turn of a lidar: returns `points_m` (N, 2) in the chair's frame, ordered by bearing.

    `origin_m`: where the lidar sits.
    """

    points_m: FloatArray
    origin_m: tuple[float, float]
    at_s: float


@dataclass(frozen=True, eq=False)
class Cluster:
    """Returns that belong together. `wide`: too wide for one leg, such as a skirt.

    `whole`: nothing nearer hides a part of it. `free`: it does not touch the background.
    """

    x_m: float
    y_m: float
    wide: bool
    whole: bool
    free: bool
    points_m: FloatArray

    @property
    def alone(self) -> bool:
        """True if nothing hides a part of it, nor does it touch the background."""
        return self.whole and self.free

    @property
    def maybe_wall(self) -> bool:
        """True for a wide part that shows beside something nearer."""
        return self.wide and not self.whole

    def beyond_m(self, points_m: FloatArray) -> float:
        """How far it reaches beyond these points, m."""
        off = self.points_m[:, None] - points_m
        return float(np.hypot(off[..., 0], off[..., 1]).min(axis=1).max())


def clusters(points_m: FloatArray, origin_m: FloatArray, foreground: BoolArray) -> list[Cluster]:
    """Clusters that may be one or both legs, the nearest first. Points ordered by bearing."""
    offset = points_m - origin_m
    ranges = np.hypot(offset[:, 0], offset[:, 1])
    at = np.flatnonzero(foreground & (ranges < FARTHEST_M))
    if not len(at):
        return []
    step = np.diff(points_m[at], axis=0)
    apart = np.hypot(step[:, 0], step[:, 1]) > _GAP_M + _GAP_PER_M * ranges[at[1:]]
    # Something else is seen between them.
    apart |= np.diff(at) > 1
    begins = np.concatenate(((0,), np.flatnonzero(apart) + 1))
    count = np.diff(begins, append=len(at))
    middle = np.add.reduceat(points_m[at], begins) / count[:, None]
    ends = points_m[at[begins + count - 1]] - points_m[at[begins]]
    # One beam's width more: the edges lie between beams.
    width = np.hypot(ends[:, 0], ends[:, 1]) * (count + 1) / np.maximum(count, 1)
    away = middle - origin_m
    range_m = np.maximum(np.hypot(away[:, 0], away[:, 1]), 1e-6)
    whole = np.ones(len(begins), dtype=np.bool_)
    free = whole.copy()
    for end, step_to in ((at[begins], -1), (at[begins + count - 1], 1)):
        beside = np.clip(end + step_to, 0, len(ranges) - 1)
        hidden = ranges[beside] - ranges[end] <= -_NEARER_M
        whole &= ~hidden
        off = points_m[beside] - points_m[end]
        near = np.hypot(off[:, 0], off[:, 1]) <= _GAP_M + _GAP_PER_M * ranges[end]
        free &= hidden | foreground[beside] | ~near
    least = np.where(range_m > _FAR_M, _LEAST_FAR_POINTS, _LEAST_POINTS)
    chosen = np.flatnonzero((count >= least) & (width >= _THIN_M) & (width <= _PERSON_M))
    chosen = chosen[np.argsort(range_m[chosen], kind="stable")][:_MOST]
    behind = np.minimum(_BEHIND_SHARE * width, _BEHIND_MOST_M) / range_m
    middle = middle + away * behind[:, None]
    return [
        Cluster(
            float(middle[k, 0]),
            float(middle[k, 1]),
            bool(width[k] > _LEG_M),
            bool(whole[k]),
            bool(free[k]),
            points_m[at[begins[k] : begins[k] + count[k]]],
        )
        for k in chosen
    ]


def continued(
    own: Sequence[Cluster], before: Sequence[Cluster], now: Sequence[Cluster]
) -> list[Cluster]:
    """Clusters of this scan that are of whom `own`, of those of the scan before, are.

    They lie wholly where those were, and fit none of the others better: nobody else's leg can be
    there, however little of it shows. But somebody, or a wall, may come out from behind a leg: so
    they are no more than one person's legs can look like, and more than there were only if what
    was wide has come apart.
    """
    if not own:
        return []
    there = np.concatenate([one.points_m for one in own])
    low, high = there.min(axis=0) - _SAME_M, there.max(axis=0) + _SAME_M
    others = [one for one in before if one not in own]
    found: list[tuple[float, Cluster]] = []
    for one in now:
        if (one.points_m < low).any() or (one.points_m > high).any():
            continue
        beyond_m = one.beyond_m(there)
        if beyond_m < _SAME_M and all(beyond_m < one.beyond_m(o.points_m) for o in others):
            found.append((beyond_m, one))
    nearest = [one for _, one in sorted(found, key=lambda pair: pair[0])]
    if nearest and nearest[0].wide:
        return nearest[:1]  # a skirt, or both legs: what is beside it is not theirs
    came_apart = any(one.wide for one in own)
    legs = [one for one in nearest if not one.wide][:2]
    legs = [one for k, one in enumerate(legs) if k < len(own) or (came_apart and one.free)]
    return [] if _apart_m(legs) > LEGS_APART_M else legs


def _apart_m(legs: Sequence[Cluster]) -> float:
    """Between two legs; 0: there is only one, or none."""
    return math.dist(*((one.x_m, one.y_m) for one in legs)) if len(legs) > 1 else 0.0
