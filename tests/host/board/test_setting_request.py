"""A request about a setting: repeated until answered, and honest about what may have been done."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from gazechair.board.events import SettingReply
from gazechair.board.setting_request import Answer, ask
from gazelink import codes

SET, INDEX, VALUE = codes.SETTING_SET, 4, 250
DONE = SettingReply(SET, INDEX, VALUE, 0)
REFUSED = SettingReply(SET, INDEX, 0, codes.SETTING_WHILE_ARMED)
ABOUT_ANOTHER = SettingReply(SET, INDEX + 1, 1, 0)


class Link:
    def __init__(self, replies: Sequence[SettingReply | None], connected: bool = True) -> None:
        self._replies = iter(replies)
        self._connected = connected
        self.requests: list[tuple[Any, ...]] = []

    def state(self) -> Any:
        return object() if self._connected else None

    def setting(self, *request: Any) -> SettingReply | None:
        self.requests.append(request)
        return next(self._replies)


@pytest.mark.parametrize(
    ("replies", "answer"),
    [
        ((DONE,), Answer(VALUE)),
        ((None, DONE), Answer(VALUE, unheard=True)),
        ((ABOUT_ANOTHER, DONE), Answer(VALUE, unheard=True)),
        ((REFUSED,), Answer(None, codes.SETTING_WHILE_ARMED)),
        ((None, REFUSED), Answer(None, codes.SETTING_WHILE_ARMED, unheard=True)),
        ((None, None), Answer(None, unheard=True)),
    ],
)
def test_it_is_repeated_until_the_board_answers(
    replies: Sequence[SettingReply | None], answer: Answer
) -> None:
    link = Link(replies)
    assert ask(link, SET, INDEX, VALUE, tries=2, answer_s=0.5) == answer
    assert link.requests == [(SET, INDEX, VALUE, 0.5)] * len(replies)


def test_nothing_is_requested_without_a_board() -> None:
    link = Link((), connected=False)
    assert ask(link, SET, INDEX, VALUE, tries=2, answer_s=0.5) == Answer(None)
    assert link.requests == []
