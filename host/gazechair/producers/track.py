"""The chair's present pose in a map: the map's newest pose, extended by odometry."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose
from gazechair.going.rolled import POSE_OLD_S
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.odometry import doubts
from gazechair.sensing.odometry.estimate import Estimate

ESTIMATE_OLD_S = 0.25
"""An older estimate is not valid for now."""
_SIGMA_M, _SIGMA_DEG = 0.12, 3.0  # a less certain pose counts as unknown
_SAME_S = 1e-3
DOUBTED = frozenset((doubts.LITTLE, doubts.LATE, doubts.SILENT, doubts.CARRIED, doubts.LOST))
"""An estimate with any of these is not usable for driving."""
_KEPT = 64


class MapTrack:
    """Feed it new data; `pose` returns the pose in one map."""

    def __init__(self) -> None:
        self._estimates: deque[Estimate] = deque(maxlen=_KEPT)
        self._where: Whereabouts | None = None
        self._frame: FloatArray | None = None  # odometry's frame in the map's

    def take(self, estimates: Iterable[Estimate], where: Whereabouts | None) -> None:
        """Process new data."""
        for estimate in estimates:
            if self._estimates and estimate.track != self._estimates[-1].track:
                self._estimates.clear()
                self._where = None  # nothing to extend
            self._estimates.append(estimate)
        if where is not None:
            self._place(where)

    def _place(self, where: Whereabouts) -> None:
        # The last of those with the same time, as of two lidars in step.
        newest_first = reversed(self._estimates)
        near = min(newest_first, key=lambda one: abs(one.time_s - where.time_s), default=None)
        if near is None or abs(near.time_s - where.time_s) > _SAME_S:
            return
        in_map = np.array((where.x_m, where.y_m, math.radians(where.heading_deg)))
        self._frame = compose(in_map, between(near.pose(), np.zeros(3)))
        self._where = where

    @property
    def newest(self) -> Estimate | None:
        """The newest estimate of odometry."""
        return self._estimates[-1] if self._estimates else None

    @property
    def seen_s(self) -> float:
        """When the chair was seen where `pose` says: the older of what that rests upon."""
        if self._where is None or self.newest is None:
            return -math.inf
        return min(self._where.time_s, self.newest.time_s)

    @property
    def map(self) -> str:
        """The map that the chair was last known to be in; "": none yet."""
        return "" if self._where is None else self._where.map

    def pose(self, map_: str, now_s: float) -> FloatArray | None:
        """Pose (3,) at the time of `newest`, in that map; None: not known well enough."""
        where, newest = self._where, self.newest
        if where is None or newest is None or self._frame is None or where.map != map_:
            return None
        if now_s - where.time_s > POSE_OLD_S or now_s - newest.time_s > ESTIMATE_OLD_S:
            return None
        # Whether a lidar is turned shows on the first leg, and ends it: that is no reason to wait.
        most_deg = math.hypot(_SIGMA_DEG, where.mounting_deg)
        most_m = math.hypot(_SIGMA_M, where.mounting_m)
        if where.sigma_m > most_m or where.sigma_deg > most_deg:
            return None
        if DOUBTED.intersection(newest.doubts):
            return None
        return compose(self._frame, newest.pose())
