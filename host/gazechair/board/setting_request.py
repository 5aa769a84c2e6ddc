"""A request about one of the board's settings, repeated until it is answered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from gazechair.board.events import SettingReply
from gazechair.board.state import BoardState


class Link(Protocol):
    """What this needs from the link to the board (gazechair.board.link.BoardLink)."""

    def state(self) -> BoardState | None: ...
    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None: ...


@dataclass(frozen=True)
class Answer:
    """The end of a request."""

    value: int | None
    """In force now. None: refused, or there is no answer."""
    refused: int = 0
    """Why the board refuses (gazelink.codes); 0: it does not."""
    unheard: bool = False
    """Whether a try got no answer: the board may have done it all the same."""


def ask(
    link: Link, request: int, index: int = 0, value: int = 0, *, tries: int, answer_s: float
) -> Answer:
    """Send a request (codes.SETTING_...); waits up to `answer_s` seconds for each of `tries`."""
    unheard = False
    for _ in range(tries):
        if link.state() is None:
            break
        reply = link.setting(request, index, value, answer_s)
        if reply is None or (reply.request, reply.index) != (request, index):
            unheard = True
        elif reply.refused:
            return Answer(None, reply.refused, unheard)
        else:
            return Answer(reply.value, 0, unheard)
    return Answer(None, 0, unheard)
