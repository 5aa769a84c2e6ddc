"""Decides whether a chair whose pose is not known stands and waits, or its motion is over.

A late estimate, a moment without sight or a position that is not sure passes: the chair stands
meanwhile, and goes on by itself. Where others move it, or odometry starts again, it does not.
"""

from __future__ import annotations

import math

from gazechair.producers.moved_by_others import MovedByOthers
from gazechair.producers.odometry_track import OdometryTrack
from gazechair.sensing.odometry import doubts

KNOWN, DOUBTED, LOST = "known", "doubted", "lost"
ENDS_S = 0.45
"""An older pose is lost: the motion ends within 0.5 s (promise P20), a step included."""
STANDS_S = 3.0
"""Longest doubt of a pose that is known for moments only, and longest wait for the first one."""
AGAIN_S = 0.25
"""For how long a doubted pose must be known before the chair moves again."""
MOVED_BY_OTHERS = frozenset((doubts.CARRIED, doubts.LOST, doubts.PUSHED))
"""An estimate with any of these: the chair may be elsewhere than its motion brought it."""


class PoseWatch:
    """Call `begin` for a new motion, `judge` in each step. The chair moves while KNOWN only."""

    def __init__(self) -> None:
        self._moved_by_others = MovedByOthers()
        self.begin()

    def begin(self) -> None:
        """A new motion: doubts of the one before do not count."""
        self._track: int | None = None  # in which the pose was known
        self._seen_s = self._doubted_s = self._again_s = math.inf

    def judge(self, seen_s: float | None, track: OdometryTrack, now_s: float) -> str:
        """KNOWN, DOUBTED or LOST.

        `seen_s`: when the chair was at its pose; None: that is not known well enough.
        """
        newest = track.newest
        if seen_s is not None:
            self._seen_s = seen_s
            if newest is not None and math.isinf(self._doubted_s):
                self._track = newest.track
                self._moved_by_others.begin(now_s)
                return KNOWN
        self._doubted_s = min(self._doubted_s, now_s)
        if now_s - self._seen_s > ENDS_S or now_s - self._doubted_s > STANDS_S:
            return LOST
        if self._is_elsewhere(track, now_s):
            return LOST
        self._again_s = math.inf if seen_s is None else min(self._again_s, now_s)
        if now_s - self._again_s >= AGAIN_S:
            self._doubted_s = self._again_s = math.inf
        return DOUBTED

    def _is_elsewhere(self, track: OdometryTrack, now_s: float) -> bool:
        """Whether the chair may be elsewhere than where it came to rest."""
        newest = track.newest
        if self._track is None or newest is None:
            return False
        if newest.track != self._track or MOVED_BY_OTHERS.intersection(newest.doubts):
            return True
        return self._moved_by_others.moved(track, now_s)
