"""A request about a setting: repeated until answered, and honest about what may have been done."""

from __future__ import annotations

import math
import time
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
    def __init__(self, replies: Sequence[SettingReply | None], away: float = 0) -> None:
        """`away`: it is not connected when it is first looked for, so often."""
        self._replies = iter(replies)
        self.away = away
        self.requests: list[tuple[Any, ...]] = []

    def state(self) -> Any:
        self.away -= 1
        return object() if self.away < 0 else None

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
    link = Link((), away=math.inf)
    assert ask(link, SET, INDEX, VALUE, tries=2, answer_s=0.5) == Answer(None)
    assert link.requests == []


class Gap(Link):
    """A link that loses the first request, and is gone for two looks after it."""

    def setting(self, *request: Any) -> SettingReply | None:
        reply = super().setting(*request)
        if reply is None:
            self.away = 2
        return reply


def test_a_gap_between_two_tries_is_waited_out() -> None:
    link = Gap((None, DONE))
    answer = ask(link, SET, INDEX, VALUE, tries=2, answer_s=0.5, gap_s=3.0)
    assert answer == Answer(VALUE, unheard=True)
    assert len(link.requests) == 2


def test_a_gap_ends_the_request_of_one_who_does_not_wait() -> None:
    link = Gap((None, DONE))
    assert ask(link, SET, INDEX, VALUE, tries=2, answer_s=0.5) == Answer(None, unheard=True)
    assert len(link.requests) == 1


def test_a_board_that_stays_away_is_not_waited_for_again() -> None:
    link = Link((), away=math.inf)
    begun_s = time.monotonic()
    assert ask(link, SET, INDEX, VALUE, tries=50, answer_s=0.5, gap_s=0.1) == Answer(None)
    assert time.monotonic() - begun_s < 4.0
