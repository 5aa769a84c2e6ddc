"""Predicts the speed from the command, and checks whether the chair follows it."""

from __future__ import annotations

import math
from dataclasses import dataclass

DEAD_S = 0.15
CHANGED_S = 1.2  # for this long after a change of the command the speed is hard to predict
_LAG_S = 0.25
_FASTER_M_S2, _SLOWER_M_S2 = 0.6, 1.0
_STEADY_Q, _CHANGING_Q = 0.003, 0.05  # (m/s)^2 per second
_OTHER_WAY = 0.15  # a chair's speed backward differs so much from that forward, or more
_SURPRISE_S, _SURPRISE_M_S2, _CHANGING_M_S2 = 0.15, 0.15, 0.2


@dataclass(frozen=True)
class Change:
    """Change of the speed in one step, with its derivatives."""

    speed_m_s: float
    """The change."""
    by_speed: float
    """Derivative of the new speed by the old one."""
    by_full: float
    """Derivative of the new speed by the speed of a full command."""
    q: float
    """Process noise: variance of the change per second."""
    full_variance: float = 0.0
    """By so much the speed of a full command is less sure, (m/s)^2."""
    learns: bool = True
    """Whether the new speed tells the speed of a full command."""


class SpeedByCommand:
    """Predicts by the command for as long as the chair roughly follows it."""

    def __init__(self) -> None:
        self._surprise_m_s2 = 0.0
        self._expected_m_s = 0.0
        self._command = self._before = 0.0  # the newest, and the one before, that were not 0

    def predict(
        self,
        speed_m_s: float,
        full_m_s: float,
        full_sigma_m_s: float,
        command: float | None,
        changing: bool,
        dt_s: float,
    ) -> Change:
        """`full_m_s`: the speed of a full command; `command`: -1..1, None: not known."""
        if command is None:
            self._expected_m_s, self._surprise_m_s2 = 0.0, math.inf
            return Change(0.0, 1.0, 0.0, _CHANGING_Q)
        if math.isinf(self._surprise_m_s2):
            self._surprise_m_s2 = 0.0
        self._command = command or self._before
        turns_back = self._command * self._before < 0.0
        less_sure = turns_back * (_OTHER_WAY * full_m_s) ** 2
        follow = 1.0 - math.exp(-dt_s / _LAG_S)
        wanted = command * full_m_s
        change = (wanted - speed_m_s) * follow
        most = (_FASTER_M_S2 if abs(wanted) > abs(speed_m_s) else _SLOWER_M_S2) * dt_s
        self._expected_m_s = max(-most, min(change, most))
        allowed = _SURPRISE_M_S2
        if changing or abs(change) <= most:  # within what is not yet known of this chair
            allowed += 2.0 * abs(command) * full_sigma_m_s / _LAG_S
        if abs(self._surprise_m_s2) > allowed + changing * _CHANGING_M_S2:  # pushed, or held
            return Change(0.0, 1.0, 0.0, _CHANGING_Q, less_sure)
        q = _CHANGING_Q if changing else _STEADY_Q
        if abs(change) > most:
            return Change(self._expected_m_s, 1.0, 0.0, q, less_sure)
        # While it gains speed, a chair that is faster at a full command would be no faster yet.
        learns = not changing or abs(change) + 2.0 * abs(command) * full_sigma_m_s * follow < most
        return Change(change, 1.0 - follow, command * follow, q, less_sure, learns)

    def judge(self, change_m_s: float | None, dt_s: float) -> None:
        """Compare the last prediction with how the speed has really changed; None: not seen."""
        self._before = self._command
        if math.isinf(self._surprise_m_s2):
            return
        off_m_s = 0.0 if change_m_s is None else change_m_s - self._expected_m_s
        fades = math.exp(-dt_s / _SURPRISE_S)
        # Of two lidars in step, the second one's change is at once.
        share_s = (1.0 - fades) / dt_s if dt_s > 0.0 else 1.0 / _SURPRISE_S
        self._surprise_m_s2 = self._surprise_m_s2 * fades + off_m_s * share_s
