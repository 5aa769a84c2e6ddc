"""The chair's present and past poses in odometry's frame, to interpret older pictures."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.producers.track import DOUBTED, ESTIMATE_OLD_S
from gazechair.sensing.odometry.estimate import Estimate

_KEPT_S = 5.0  # a look is answered for 4 s
_STANDS_M_S, _STANDS_DEG_S = 0.03, 2.0
_AHEAD_S = 0.2  # a picture may be this much newer than the newest estimate


class OdometryTrack:
    """Feed it estimates in order of time. `track`: number of the frame, None: none yet."""

    def __init__(self) -> None:
        self._kept: deque[Estimate] = deque()

    def take(self, estimates: Iterable[Estimate]) -> None:
        """Add new estimates. A new track replaces the one before."""
        for one in estimates:
            if self._kept and one.track != self._kept[-1].track:
                self._kept.clear()
            self._kept.append(one)
            while self._kept[0].time_s < one.time_s - _KEPT_S:
                self._kept.popleft()

    @property
    def newest(self) -> Estimate | None:
        """The newest estimate."""
        return self._kept[-1] if self._kept else None

    def known(self, now_s: float) -> bool:
        """True if the present pose is known without doubt."""
        newest = self.newest
        if newest is None or now_s - newest.time_s > ESTIMATE_OLD_S:
            return False
        return not DOUBTED.intersection(newest.doubts)

    def seen_s(self, now_s: float) -> float | None:
        """When the chair was at its newest pose; None: the present one is in doubt."""
        newest = self.newest
        return newest.time_s if newest is not None and self.known(now_s) else None

    @property
    def stands(self) -> bool:
        """True if it hardly moves, by the newest estimate."""
        newest = self.newest
        if newest is None:
            return False
        return abs(newest.speed_m_s) < _STANDS_M_S and abs(newest.yaw_rate_deg_s) < _STANDS_DEG_S

    def pose(self, at_s: float) -> FloatArray | None:
        """Pose (3,) at that time; None: too long ago, or too new."""
        if not self._kept or at_s < self._kept[0].time_s:
            return None
        after = next((one for one in self._kept if one.time_s >= at_s), None)
        if after is None:
            newest = self._kept[-1]
            late_s = at_s - newest.time_s
            return _moved(newest, late_s) if late_s <= _AHEAD_S else None
        before = max((o for o in self._kept if o.time_s <= at_s), key=lambda o: o.time_s)
        gap_s = after.time_s - before.time_s
        share = 0.0 if gap_s <= 0.0 else (at_s - before.time_s) / gap_s
        start, end = before.pose(), after.pose()
        turned = math.remainder(end[2] - start[2], 2.0 * math.pi)
        step = np.array((*(end[:2] - start[:2]), turned))
        return np.asarray(start + share * step)


def _moved(last: Estimate, late_s: float) -> FloatArray:
    turned = math.radians(last.yaw_rate_deg_s) * late_s
    middle = math.radians(last.heading_deg) + 0.5 * turned
    c, s = math.cos(middle), math.sin(middle)
    ahead, left = last.speed_m_s * late_s, last.sideways_m_s * late_s
    step = np.array((c * ahead - s * left, s * ahead + c * left, turned))
    return np.asarray(last.pose() + step)
