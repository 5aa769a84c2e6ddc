"""The board's settings that a producer uses, read again whenever driving is off."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from gazechair.board.events import SettingReply
from gazechair.board.state import BoardId, BoardState
from gazechair.going.chair_numbers import ChairNumbers
from gazelink import codes
from gazelink.settings_table import index_of

_ANSWER_S = 0.3
_AGAIN_S = 5.0  # while driving is off


class Link(Protocol):
    """What this needs from the link to the board."""

    def state(self) -> BoardState | None: ...
    def board(self) -> BoardId | None: ...
    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None: ...


class BoardSettings:
    """Refreshed by one thread, which waits for the board's answers; readable by any."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._session = 0
        self._known: Mapping[str, int] | None = None
        self._asked_s = float("-inf")

    @property
    def known(self) -> Mapping[str, int] | None:
        """The last answers; None: the board has not answered yet. Never blocks."""
        return self._known

    def refresh(self) -> None:
        """Read again when due. May block for seconds when the board does not answer."""
        board, state = self._link.board(), self._link.state()
        if board is None or state is None:
            return
        if board.session != self._session:
            self._session, self._known, self._asked_s = board.session, None, float("-inf")
        # Settings cannot change while driving is on.
        off = state.state == codes.DISARMED
        if (off or self._known is None) and state.received_s >= self._asked_s + _AGAIN_S:
            self._asked_s = state.received_s
            self._ask()

    def _ask(self) -> None:
        answers = _Answers(self._link)
        try:
            ChairNumbers.of(answers)
        except KeyError:
            return  # no answer: keep the known values
        self._known = dict(answers)


class _Answers(dict[str, int]):
    """Reads each setting from the board when it is looked up."""

    def __init__(self, link: Link) -> None:
        super().__init__()
        self._link = link

    def __missing__(self, name: str) -> int:
        index = index_of(name)
        reply = self._link.setting(codes.SETTING_GET, index, 0, _ANSWER_S)
        if reply is None or reply.refused or reply.index != index:
            raise KeyError(name)
        self[name] = reply.value
        return reply.value
