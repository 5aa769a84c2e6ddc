"""The link to a board that keeps settings, for tests without a board."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.board.events import SettingReply
from gazechair.board.state import BoardState
from gazelink import codes
from gazelink.settings_table import TABLE


class FakeBoard:
    """The link to a board that keeps settings; `connected` False: it does not answer."""

    def __init__(self) -> None:
        self.connected = True
        self.armed = False
        self.faults = 0
        self.values = [row[1] for row in TABLE]
        self.saved: list[int] = []
        self.unanswered_saves = 0  # of the next ones: done, but nobody hears of it
        self.restarts = False  # before each SAVE: it forgets what is not in its flash
        self.refuses: Callable[[int, int], int] = lambda _request, _index: 0
        self.loses: Callable[[int, int, int], bool] = lambda _request, _index, _value: False
        """True: this request does not arrive."""

    def state(self) -> BoardState | None:
        if not self.connected:
            return None
        return BoardState(
            codes.ARMED if self.armed else 0, *[0] * 4, self.faults, 0.0, 0, 0, 0, 0, 0, 0.0
        )

    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None:
        if self.loses(request, index, value):
            return None
        if request == codes.SETTING_SAVE and self.restarts:
            self.values = list(self.saved) or [row[1] for row in TABLE]
        refused = self.refuses(request, index)
        if request == codes.SETTING_SET and not refused:
            self.values[index] = value
        elif request == codes.SETTING_DEFAULTS and not refused:
            neutral = "neutral_linear_count", "neutral_turn_count"
            rows = zip(TABLE, self.values, strict=True)
            self.values = [value if row[0] in neutral else row[1] for row, value in rows]
        elif request == codes.SETTING_SAVE and not refused:
            self.saved = list(self.values)
            if self.unanswered_saves:
                self.unanswered_saves -= 1
                return None
        return SettingReply(request, index, self.values[index], refused)
