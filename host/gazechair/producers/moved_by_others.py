"""Detects that the chair was moved by others, which ends what was chosen from its old pose."""

from __future__ import annotations

import math

from gazechair.base.arrays import FloatArray
from gazechair.producers.odometry_track import OdometryTrack

_BRAKES_S = 3.0
"""How long the chair may roll on after a look or a press."""
_MOVED_M, _MOVED_RAD = 0.1, math.radians(5.0)


class MovedByOthers:
    """Call `begin` after anything that may leave the chair rolling; then `moved` in each step."""

    def __init__(self) -> None:
        self._begun_s = -math.inf
        self._pose: FloatArray | None = None

    def begin(self, at_s: float) -> None:
        """Take the place where the chair comes to rest after `at_s`."""
        self._begun_s, self._pose = at_s, None

    def moved(self, track: OdometryTrack, now_s: float) -> bool:
        """True if it was moved, or does not come to rest."""
        if not track.stands and now_s - self._begun_s > _BRAKES_S:
            return True
        pose = track.pose(now_s)
        if pose is None:
            return False
        if self._pose is None:
            self._pose = pose if track.stands else None
            return False
        off = pose - self._pose
        turned = abs(math.remainder(off[2], 2.0 * math.pi))
        return math.hypot(off[0], off[1]) > _MOVED_M or turned > _MOVED_RAD
