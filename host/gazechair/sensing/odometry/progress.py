"""The mean speed of the last moments, by positions alone: no command is in it."""

from __future__ import annotations

import math
from collections import deque

_STANDS_S = 0.3  # the motion within this time shows whether it stands


class Progress:
    """Feed it every position."""

    def __init__(self) -> None:
        self._places: deque[tuple[float, float, float]] = deque()

    def take(self, at_s: float, x_m: float, y_m: float, heading_rad: float) -> tuple[float, float]:
        """The speed, and its part along the chair, m/s."""
        self._places.append((at_s, x_m, y_m))
        while self._places[0][0] < at_s - _STANDS_S and len(self._places) > 2:
            self._places.popleft()
        begin_s, x, y = self._places[0]
        passed_s = max(at_s - begin_s, _STANDS_S)
        dx, dy = x_m - x, y_m - y
        ahead_m = math.cos(heading_rad) * dx + math.sin(heading_rad) * dy
        return math.hypot(dx, dy) / passed_s, ahead_m / passed_s
