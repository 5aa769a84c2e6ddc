"""Records where the chair requests motion without progress, for how long, and what was tried.

The board counts how long it overrules an auto motion, and ends its press after 10 s. So a refused
request is repeated for moments only, and less often as that time runs out.
"""

from __future__ import annotations

import math

from gazechair.going.follow import STOP, Stick
from gazechair.going.pace import PERIOD_S
from gazechair.going.smooth import Pose

_MOVED_M, _MOVED_RAD = 0.04, math.radians(2.0)
_IN_VAIN_S = 0.6
_SILENT_S = 1.2  # no output since the first request: short requests are in vain, too
_IDLE_S = 8.0  # longer than the pauses of a turn by pulses
_LET_OUT_S = 3.0  # output for this long that does not move the chair is in vain
_ASKS_S, _OF_S = 0.1, 1.0
_SELDOM_S = 6.0  # overruled for longer: request less often
_SELDOM_ASKS_S, _SELDOM_OF_S = 0.05, 3.0


class Overruled:
    """How long the board has overruled requests since its last output."""

    def __init__(self) -> None:
        self._seconds = self._before_s = 0.0

    def another_path(self) -> None:
        """Another path is driven: what it requests may be permitted."""
        self._before_s = self._seconds

    def count(self, asked: Stick, put_out: Stick) -> None:
        """Count the last period."""
        if put_out != STOP:
            self._seconds = self._before_s = 0.0
        elif asked != STOP:
            self._seconds += PERIOD_S

    def asks(self, for_s: float, now_s: float) -> bool:
        """Whether to request motion now, after requests in vain for `for_s`."""
        if self._seconds < _SELDOM_S:
            return not for_s or for_s % _OF_S < _ASKS_S
        return now_s % _SELDOM_OF_S < _SELDOM_ASKS_S

    def asks_meanwhile(self, now_s: float) -> bool:
        """The same while another path is computed, however long that takes."""
        in_vain = self._seconds - self._before_s >= _IN_VAIN_S
        return self.asks(now_s if in_vain else 0.0, now_s)


class Stuck:
    """One pose at which the chair requests a turn, or to drive."""

    def __init__(self, pose: Pose | None = None, turns: bool = False, looked: bool = False) -> None:
        self.pose = pose
        self.looked = looked
        """Another path was searched for."""
        self.turns = turns
        """It requests a turn on the spot."""
        self.let_out = False
        """Output for long has not moved the chair."""
        self._idle_s = 0.0
        self._since_s: float | None = None
        self._vain_s = self._let_s = 0.0
        self._silent_since_s: float | None = None

    def elsewhere(self, pose: Pose) -> bool:
        """Whether the chair has moved away from this pose."""
        return self.pose is None or apart(self.pose, pose)

    def count(self, asked: bool, put_out: Stick, now_s: float) -> None:
        """Count the last period: whether motion was requested, and what was put out."""
        if put_out != STOP:
            self._silent_since_s = None
        if not asked:
            self._let_s = 0.0
            return
        if put_out == STOP and self._silent_since_s is None:
            self._silent_since_s = now_s
        self._let_s = 0.0 if put_out == STOP else self._let_s + PERIOD_S
        self.let_out = self.let_out or self._let_s > _LET_OUT_S
        if put_out == STOP or self._let_s > _LET_OUT_S:
            self._vain_s += PERIOD_S
            if self._since_s is None:
                self._since_s = now_s

    def idles(self) -> bool:
        """Count a period in which a path requests nothing; True once in many."""
        self._idle_s += PERIOD_S
        idles = self._idle_s > _IDLE_S
        if idles:
            self._idle_s = 0.0
        return idles

    def for_s(self, now_s: float) -> float:
        """Seconds since the first request in vain; 0: it moves, or has hardly requested."""
        silent_s = 0.0 if self._silent_since_s is None else now_s - self._silent_since_s
        hardly = self._vain_s < _IN_VAIN_S and silent_s < _SILENT_S
        if self._since_s is None or hardly or 0.0 < self._let_s < _LET_OUT_S:
            return 0.0
        return now_s - self._since_s


def apart(a: Pose, b: Pose) -> bool:
    """Whether the chair has moved from one to the other."""
    turned = abs(math.remainder(a[2] - b[2], 2.0 * math.pi))
    return math.dist(a[:2], b[:2]) > _MOVED_M or turned > _MOVED_RAD
