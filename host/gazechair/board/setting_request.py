"""A request about one of the board's settings, repeated until it is answered."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Protocol

from gazechair.board.events import SettingReply
from gazechair.board.state import BoardState

_LOOK_S = 0.05


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
    link: Link,
    request: int,
    index: int = 0,
    value: int = 0,
    *,
    tries: int,
    answer_s: float,
    gap_s: float = 0.0,
) -> Answer:
    """Send a request (codes.SETTING_...); waits up to `answer_s` seconds for each of `tries`.

    `gap_s`: how long each try waits, before it sends, for a board that is not connected.
    """
    unheard = False
    for _ in range(tries):
        if not _connected(link, gap_s):
            break
        reply = link.setting(request, index, value, answer_s)
        if reply is None or (reply.request, reply.index) != (request, index):
            unheard = True
        elif reply.refused:
            return Answer(None, reply.refused, unheard)
        else:
            return Answer(reply.value, 0, unheard)
    return Answer(None, 0, unheard)


def _connected(link: Link, gap_s: float) -> bool:
    """Whether a board is connected, or soon."""
    end_s = time.monotonic() + gap_s
    while link.state() is None:
        if time.monotonic() >= end_s:
            return False
        time.sleep(_LOOK_S)
    return True
