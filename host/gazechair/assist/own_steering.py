"""How much the driver has steered against assist lately, and how much help that leaves."""

from __future__ import annotations

import math

_AFTER_S = 3.0  # a turn this soon after assist steered is a correction
_HALVES_DEG = 20.0  # corrections of this much halve the help
_FORGETS_S = 15.0
_SLICE_S = 0.3  # longest time between two calls for one held turn


class OwnSteering:
    """A turn held soon after assist steered is a correction; other turns choose a direction."""

    def __init__(self) -> None:
        self._corrected_deg = 0.0
        self._at_s = 0.0
        self._steered_s = -math.inf
        self._seen: tuple[float, float] | None = None  # by turns(): last time and heading
        self._corrects = False

    def steered(self, now_s: float) -> None:
        """Assist steers at `now_s`."""
        self._steered_s = now_s

    def turns(self, heading_deg: float, now_s: float) -> None:
        """The driver holds a turn: call it repeatedly. `heading_deg` is not wrapped."""
        seen, self._seen = self._seen, (now_s, heading_deg)
        if seen is None or now_s - seen[0] > _SLICE_S:
            self._corrects = now_s - self._steered_s <= _AFTER_S
        elif self._corrects:
            self._corrected_deg = self._left_deg(now_s) + abs(heading_deg - seen[1])
            self._at_s = now_s

    def heading_lost(self) -> None:
        """The next heading has nothing to do with those before."""
        self._seen = None

    def help(self, now_s: float) -> float:
        """Share of the full help, 0..1: corrections reduce it, and are forgotten in time."""
        return 1.0 / (1.0 + self._left_deg(now_s) / _HALVES_DEG)

    def _left_deg(self, now_s: float) -> float:
        return self._corrected_deg * math.exp(-max(0.0, now_s - self._at_s) / _FORGETS_S)
