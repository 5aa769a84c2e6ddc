"""Reads the board's settings that a producer uses.

It reads them repeatedly while driving is off, and once more when driving is switched on.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from gazechair.board import setting_request
from gazechair.board.state import BoardId
from gazechair.going.chair_numbers import ChairNumbers
from gazelink import codes
from gazelink.settings_table import index_of

_ANSWER_S = 0.3
_AGAIN_S = 5.0  # while driving is off
_RETRY_S = 1.0  # while driving is on and the board has not answered


class Link(setting_request.Link, Protocol):
    """What this needs from the link to the board."""

    def board(self) -> BoardId | None: ...


class ChairSettings:
    """Refreshed by one thread, which waits for the board's answers; readable by any."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._session = 0
        self._known: Mapping[str, int] | None = None
        self._requested_s = float("-inf")
        self._stale = True  # the settings may have been changed since the last answers

    @property
    def known(self) -> Mapping[str, int] | None:
        """The last answers; None: the board has not answered yet, or not since driving was
        switched on. Never blocks."""
        return self._known

    def refresh(self) -> None:
        """Read again when due. May block for seconds when the board does not answer."""
        board, state = self._link.board(), self._link.state()
        if board is None or state is None:
            return
        if board.session != self._session:
            self._session, self._known, self._requested_s = board.session, None, float("-inf")
            self._stale = True
        # Settings cannot change while driving is on: the first answers from then on hold.
        off = state.state == codes.DISARMED
        self._stale = self._stale or off
        if not self._stale:
            return
        switched_on = not off and self._known is not None
        again_s = _AGAIN_S if off else _RETRY_S
        if switched_on or state.received_s >= self._requested_s + again_s:
            self._requested_s = state.received_s
            self._ask(off)

    def _ask(self, off: bool) -> None:
        answers = _Answers(self._link)
        try:
            ChairNumbers.of(answers)
        except KeyError:
            if not off:
                self._known = None  # no motion may use numbers that may be old
            return
        self._known, self._stale = dict(answers), off


class _Answers(dict[str, int]):
    """Reads each setting from the board when it is looked up."""

    def __init__(self, link: Link) -> None:
        super().__init__()
        self._link = link

    def __missing__(self, name: str) -> int:
        answer = setting_request.ask(
            self._link, codes.SETTING_GET, index_of(name), tries=1, answer_s=_ANSWER_S
        )
        if answer.value is None:
            raise KeyError(name)
        self[name] = answer.value
        return answer.value
