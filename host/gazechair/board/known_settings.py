"""The board's settings that the host uses: read once a session, then kept up to date. Pure.

One after another once the relay's is answered, as the board answers one at a time.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from gazechair.board.events import SettingReply
from gazechair.board.relay import ASK_PERIOD_S
from gazelink import codes
from gazelink.settings_table import NAMES, PROFILES, index_of, profile_row

KNOWN = (
    *("profile", "step_turn_q4_deg", "neutral_linear_count", "neutral_turn_count"),
    *(profile_row(row, "tuned") for row in range(len(PROFILES))),
)
_INDICES = tuple(index_of(name) for name in KNOWN)
_RELAY = index_of("relay_fitted")
_ANSWERED = (codes.SETTING_GET, codes.SETTING_SET, codes.SETTING_SET_NEUTRAL)


class KnownSettings:
    """As far as the board has answered. Times are monotonic seconds."""

    def __init__(self) -> None:
        self.values: Mapping[str, int] = {}
        """{name: value in force}; another object after each change."""
        self._due_s = math.inf

    def forget(self) -> None:
        """A session has begun: nothing is known any more."""
        self.values = {}
        self._due_s = math.inf

    def due(self, now_s: float) -> tuple[int, int, int] | None:
        """The SETTING to send now (request, index, value), or None."""
        if now_s < self._due_s:
            return None
        self._due_s = now_s + ASK_PERIOD_S
        return codes.SETTING_GET, next(i for i in _INDICES if NAMES[i] not in self.values), 0

    def due_s(self) -> float:
        """When to ask again; infinity once everything is known."""
        return self._due_s

    def received(self, reply: SettingReply, now_s: float) -> None:
        """An answer about any setting, to whomever."""
        if reply.refused:
            return
        if reply.request == codes.SETTING_DEFAULTS:
            self.values = {}
            self._due_s = now_s
        elif reply.index == _RELAY:
            if len(self.values) < len(_INDICES):  # some may be known: others ask, too
                self._due_s = now_s
        elif reply.request in _ANSWERED and reply.index in _INDICES:
            self.values = {**self.values, NAMES[reply.index]: reply.value}
            if self._due_s < math.inf:
                self._due_s = math.inf if len(self.values) == len(_INDICES) else now_s
