"""Detects steps of the heading sensor: faster than any chair turns, unless something hits it.

Whether the chair has turned is for the lidars to say. A step that they have not seen is the
sensor's fault, and taken out of its headings for good.
"""

from __future__ import annotations

from collections import deque

_STEP_DEG = 1.0  # six times the noise
_LATE_S = 0.04  # a heading may be from this much earlier or later than its time says
_FASTER_DEG_S2 = 200.0  # more than any chair
_RATE_S, _LEAST_S = 0.1, 0.03  # time over which the rate before is measured


class HeadingSteps:
    """Feed it the headings, full turns counted."""

    def __init__(self) -> None:
        self._recent: deque[tuple[float, float]] = deque()  # s, deg
        self.open: list[tuple[float, float]] = []
        """Time and size in degrees of each step that nobody has judged yet."""

    def take(self, time_s: float, deg: float) -> None:
        """Take in the newest heading."""
        recent = self._recent
        while recent and recent[0][0] < time_s - _RATE_S:
            recent.popleft()
        if recent:
            last_s, last_deg = recent[-1]
            span_s, dt_s = last_s - recent[0][0], time_s - last_s
            rate = (last_deg - recent[0][1]) / span_s if span_s >= _LEAST_S else 0.0
            off = deg - last_deg - rate * dt_s
            if abs(off) > _STEP_DEG + _LATE_S * abs(rate) + 0.5 * _FASTER_DEG_S2 * dt_s**2:
                self.open.append((time_s, off))
                self._recent = recent = deque((at_s, one + off) for at_s, one in recent)
        recent.append((time_s, deg))

    def lost(self) -> None:
        """There is no heading: the next one may begin anywhere."""
        self._recent.clear()
        self.open.clear()
