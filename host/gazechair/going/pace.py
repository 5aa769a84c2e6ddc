"""The speed to request: bounded acceleration and jerk, and slow enough to stop or bend in time."""

from __future__ import annotations

import math

from gazechair.going.chair_numbers import ChairNumbers

PERIOD_S = 0.05
ACCELERATE_M_S2, JERK_M_S3 = 0.3, 1.0
"""Limits of the requested speed."""
START_M_S2 = 0.2
"""Acceleration requested at once from rest, which the chair's own ramp and lag smooth."""
_LEAST_M_S = 0.02  # lowest speed requested from rest
_STOPS_M_S = 0.04  # a chair that has nearly reached its end goes on at this speed


class Pace:
    """The requested speed of one chair; `step` in each period in which it drives."""

    def __init__(self, numbers: ChairNumbers) -> None:
        self._numbers = numbers
        self._delay_s = numbers.lag_s + 0.5 * PERIOD_S
        self.rest()

    def rest(self) -> None:
        """The next speed is one from rest."""
        self.m_s, self._acceleration = _LEAST_M_S, START_M_S2

    def held(self, speed_m_s: float) -> None:
        """The board put nothing out: go on from the chair's own speed, gently."""
        self.m_s = max(_LEAST_M_S, min(self.m_s, abs(speed_m_s)))

    def slows_m_s(self, left_m: float, to_m_s: float) -> float:
        """Speed from which the chair slows down to `to_m_s` within `left_m`."""
        late = ACCELERATE_M_S2 * self._delay_s
        squared = late**2 + to_m_s**2 + 2.0 * ACCELERATE_M_S2 * max(left_m, 0.0)
        return max(to_m_s, math.sqrt(squared) - late)

    def step(self, left_m: float, most_m_s: float) -> float:
        """Speed for the next period, m/s: at most `most_m_s`, and the chair stops in `left_m`."""
        braked = ACCELERATE_M_S2 * self._delay_s
        to_stop = -braked + math.sqrt(braked**2 + 2.0 * ACCELERATE_M_S2 * left_m)
        wanted = min(self._numbers.most_m_s, most_m_s, max(to_stop, _STOPS_M_S))
        gap = wanted - self.m_s
        aim = max(-2.0 * ACCELERATE_M_S2, min(ACCELERATE_M_S2, gap / 0.3))
        change = JERK_M_S3 * PERIOD_S
        self._acceleration += max(-2.0 * change, min(change, aim - self._acceleration))
        self.m_s = max(0.0, self.m_s + self._acceleration * PERIOD_S)
        if self.m_s >= wanted:
            self.m_s = max(wanted, self.m_s - 2.0 * ACCELERATE_M_S2 * PERIOD_S)
        return self.m_s if wanted > 0.0 else 0.0
