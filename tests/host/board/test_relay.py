"""Relay monitoring: requested once per session, false unless the board confirms in time."""

from __future__ import annotations

from typing import Any

import pytest

from gazechair.board.state import BoardState
from gazelink import codes
from gazelink.settings_table import index_of

RELAY = index_of("relay_fitted")


def checked(line: Any) -> bool:
    (state,) = line.say(line.board.state())
    assert isinstance(state, BoardState)
    return state.relay_checked


def requested(line: Any) -> list[tuple[int, int]]:
    # What the link asks of turns: test_turn_settings.
    rows = [(row["request"], row["index"]) for row in line.board.take("setting")]
    return [row for row in rows if row[1] in (RELAY, 3)]


def answer(line: Any, **reply: int) -> None:
    line.say(line.board.setting_reply(**({"index": RELAY} | reply)))


@pytest.mark.parametrize("fitted", [0, 1])
def test_an_answer_ends_the_question(line: Any, fitted: int) -> None:
    line.turn()
    line.turn(5)
    assert requested(line) == [(codes.SETTING_GET, RELAY)]
    answer(line, value=fitted)
    assert checked(line) == bool(fitted)
    line.turn(2000)
    assert requested(line) == []
    assert checked(line) == bool(fitted)


def test_a_lost_answer_is_asked_for_again(joined: Any) -> None:
    joined.turn(450)
    assert len(requested(joined)) >= 2
    answer(joined, value=1)
    joined.turn(1000)
    assert requested(joined) == []


def test_silence_means_unmonitored_but_not_at_once(joined: Any) -> None:
    joined.turn(400)
    assert checked(joined)
    joined.turn(200)
    assert not checked(joined)
    answer(joined, value=1)
    assert checked(joined)


def test_answers_about_anything_else_do_not_count(joined: Any) -> None:
    answer(joined, index=RELAY + 1, value=1)
    answer(joined, value=1, refused=codes.SETTING_UNKNOWN)
    joined.turn(600)
    assert not checked(joined)


def test_somebody_elses_question_goes_first_and_alone(line: Any) -> None:
    line.turn()
    line.board.received.clear()
    line.protocol.request_setting(codes.SETTING_GET, 3, 0)
    line.turn()
    assert requested(line) == [(codes.SETTING_GET, 3)]
    line.turn(300)
    assert requested(line) == [(codes.SETTING_GET, RELAY)] * 2


def test_a_new_session_asks_anew(joined: Any) -> None:
    answer(joined, value=1)
    joined.board.restart()
    joined.say(joined.board.hello())
    joined.turn(10)
    assert requested(joined) == [(codes.SETTING_GET, RELAY)]
    joined.turn(600)
    assert not checked(joined)
