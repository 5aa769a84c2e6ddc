"""Whether the board monitors its safety relay: requested once a session until answered. Pure."""

from __future__ import annotations

import math

from gazelink import codes
from gazelink.settings_table import index_of

ASK_PERIOD_S = 0.2
ANSWER_S = 0.5  # a board answers within some ms; a shorter silence means nothing

_INDEX = index_of("relay_fitted")


class RelayQuestion:
    """The board's setting relay_fitted, as far as it is known. Times are monotonic seconds."""

    def __init__(self) -> None:
        self._answer: bool | None = None
        self._begun_s = 0.0
        self._due_s = math.inf

    def begin(self, now_s: float) -> None:
        """A session has begun: an answer from an earlier one does not count."""
        self._answer = None
        self._begun_s = now_s
        self._due_s = now_s

    def due(self, now_s: float) -> tuple[int, int, int] | None:
        """The SETTING to send now (request, index, value), or None."""
        if now_s < self._due_s:
            return None
        self._due_s = now_s + ASK_PERIOD_S
        return codes.SETTING_GET, _INDEX, 0

    def due_s(self) -> float:
        """When to request it again; infinity once answered."""
        return self._due_s

    def received(self, index: int, value: int, refused: int) -> None:
        """A SETTING_REPLY: `value` is in force for the setting `index`; 0 = not `refused`."""
        if index == _INDEX and not refused:
            self._answer = value != 0
            self._due_s = math.inf

    def checked(self, now_s: float) -> bool:
        """False when the board reports that nothing monitors its relay, or is too late."""
        if self._answer is None:
            return now_s - self._begun_s <= ANSWER_S
        return self._answer
