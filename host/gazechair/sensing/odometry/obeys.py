"""Health part: whether the chair moves when commanded, and only then."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.board.state import BoardState
from gazechair.sensing.odometry.doubts import BY_HEADING, PUSHED, STUCK, UNSURE
from gazechair.sensing.odometry.estimate import Estimate
from gazelink import codes

_ARMED_S = 1.5  # before that it may still roll from being driven by hand
_KEPT_S = 1.0  # a report stays for this long, so that it can be read


class Obeys:
    """Judges while driving is on, and only while the chair's motion is measured."""

    def __init__(self, health: Health, state: Callable[[], BoardState | None]) -> None:
        self._health = health
        self._state = state
        self._armed_s: float | None = None
        self._bad_s = 0.0
        self.unknown()

    def unknown(self) -> None:
        """Report that the motion is not measured."""
        self._health.set(states.OK)

    def judge(self, estimate: Estimate) -> None:
        """Report by `estimate` whether the chair obeys."""
        now_s = estimate.time_s
        state = self._state()
        if state is None or state.state != codes.ARMED:
            self._armed_s = None
        elif self._armed_s is None:
            self._armed_s = now_s
        sure = BY_HEADING in estimate.doubts or not UNSURE.intersection(estimate.doubts)
        armed_s = 0.0 if self._armed_s is None else now_s - self._armed_s
        if sure and armed_s > _ARMED_S and PUSHED in estimate.doubts:
            self._bad_s = now_s
            self._health.set(states.LOST, "motion_uncommanded", "it moves, and is not told to")
        elif sure and armed_s > 0.0 and STUCK in estimate.doubts:
            self._bad_s = now_s
            self._health.set(states.DEGRADED, "motion_stuck", "it is told to move, and stands")
        elif now_s - self._bad_s > _KEPT_S:
            self._health.set(states.OK)
