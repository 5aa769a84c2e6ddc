"""The board's settings that a producer goes by, asked again each time driving was off."""

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
    """What it needs of the link to the board."""

    def state(self) -> BoardState | None: ...
    def board(self) -> BoardId | None: ...
    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None: ...


class BoardSettings:
    """Refreshed by one thread, which waits for the board's answers; read by any."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._session = 0
        self._known: Mapping[str, int] | None = None
        self._asked_s = float("-inf")

    @property
    def known(self) -> Mapping[str, int] | None:
        """As last answered; None: the board has not answered yet. Never waits."""
        return self._known

    def refresh(self) -> None:
        """Ask again when it is time. May wait for seconds when the board does not answer."""
        board, state = self._link.board(), self._link.state()
        if board is None or state is None:
            return
        if board.session != self._session:
            self._session, self._known, self._asked_s = board.session, None, float("-inf")
        # Nobody changes a setting while driving is on.
        off = state.state == codes.DISARMED
        if (off or self._known is None) and state.received_s >= self._asked_s + _AGAIN_S:
            self._asked_s = state.received_s
            self._ask()

    def _ask(self) -> None:
        answers = _Answers(self._link)
        try:
            ChairNumbers.of(answers)
        except KeyError:
            return  # it did not answer: what was known stays
        self._known = dict(answers)


class _Answers(dict[str, int]):
    """Asks the board for each setting that somebody looks up."""

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
