"""Selects how large a picture one viewer's link can carry without delay. Pure: times are passed in.

A picture's transfer time, from sending to acknowledgement, is the link's own delay plus the time
for its bytes. The smallest level shows the first part; a larger one may take BUDGET_S longer. A
level that takes more is left, and tried again later: after 5 s, then 10, 20 ... 60 s.
"""

from __future__ import annotations

BUDGET_S = 0.06
_CLIMB_S = BUDGET_S / 2  # more than this, and the next level would hardly fit
_GOOD = 3  # good transfers in a row before a larger level is tried
_POOR = 2  # poor transfers in a row before a level is left
_FAR_TOO_LONG_S = 3 * BUDGET_S  # this once is enough
_RETRY_S = (5.0, 10.0, 20.0, 40.0, 60.0)
_DELAY_MOVED_S = 0.03  # the link has changed: discard what is known about it


class Pacing:
    """The level of one viewer's next picture, 0 (smallest) to `top`."""

    def __init__(self, top: int) -> None:
        self.level = 0
        self._top = top
        self._delay_s: float | None = None  # of the smallest level
        self._last_s = 0.0
        self._good = 0
        self._poor = 0
        self._failed = [0] * (top + 1)  # times each level was left
        self._retry_s = [0.0] * (top + 1)  # not before

    @property
    def way_s(self) -> float:
        """Estimated time of the next picture to the page, from the last one.

        An acknowledgement takes about half of the smallest picture's round trip.
        """
        return max(0.0, self._last_s - (self._delay_s or 0.0) / 2)

    def acknowledged(self, journey_s: float, now_s: float) -> None:
        """A picture of the present level was acknowledged after `journey_s`."""
        self._last_s = journey_s
        if self.level == 0:
            self._learn(journey_s)
        assert self._delay_s is not None  # the first picture is of level 0
        over_s = journey_s - self._delay_s
        if self.level > 0 and over_s > BUDGET_S:
            self._good = 0
            self._poor += 1
            if self._poor >= _POOR or over_s > _FAR_TOO_LONG_S:
                self._leave(now_s)
            return
        self._poor = 0
        self._good = self._good + 1 if over_s <= _CLIMB_S else 0
        above = self.level + 1
        if self._good >= _GOOD and above <= self._top and now_s >= self._retry_s[above]:
            self._good = 0
            self.level = above

    def _learn(self, journey_s: float) -> None:
        old_s = self._delay_s
        if old_s is None or abs(journey_s - old_s) > _DELAY_MOVED_S:
            self._failed = [0] * len(self._failed)
            self._retry_s = [0.0] * len(self._retry_s)
            self._good = 0
            self._delay_s = journey_s
        else:
            self._delay_s = 0.75 * old_s + 0.25 * journey_s

    def _leave(self, now_s: float) -> None:
        level = self.level
        wait_s = _RETRY_S[min(self._failed[level], len(_RETRY_S) - 1)]
        self._failed[level] += 1
        self._retry_s[level] = now_s + wait_s
        self._poor = 0
        self.level = level - 1
