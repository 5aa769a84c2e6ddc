"""The settings that the host uses: requested one after another, updated, forgotten."""

from __future__ import annotations

from typing import Any

from gazechair.board.known_settings import KNOWN
from gazechair.board.state import BoardState
from gazelink import codes
from gazelink.settings_table import index_of

RELAY = index_of("relay_fitted")


def answer(line: Any, index: int, value: int, request: int = codes.SETTING_GET) -> None:
    line.say(line.board.setting_reply(request=request, index=index, value=value))


def requested(line: Any) -> list[int]:
    return [row["index"] for row in line.board.take("setting")]


def state(line: Any) -> BoardState:
    (found,) = line.say(line.board.state())
    assert isinstance(found, BoardState)
    return found


def all_answered(line: Any, **values: int) -> None:
    answer(line, RELAY, 1)
    line.board.received.clear()
    for name in KNOWN:
        line.turn()
        assert requested(line) == [index_of(name)]
        answer(line, index_of(name), values.get(name, 0))


def test_they_are_asked_one_after_another_after_the_relay(joined: Any) -> None:
    joined.turn(300)
    assert set(requested(joined)) == {RELAY}
    assert state(joined).tuned is None
    all_answered(joined, profile=2, p3_1_tuned=1, step_turn_q4_deg=160)
    joined.turn(1000)
    assert requested(joined) == []
    assert state(joined).profile == "3.1"
    assert state(joined).tuned is True
    assert state(joined).step_deg == 10.0


def test_one_that_is_not_answered_is_asked_again(joined: Any) -> None:
    answer(joined, RELAY, 1)
    joined.board.received.clear()
    joined.turn(450)
    assert requested(joined) == [index_of(KNOWN[0])] * 3


def test_what_anybody_sets_is_followed(joined: Any) -> None:
    all_answered(joined, profile=2, p3_1_tuned=1)
    answer(joined, index_of("profile"), 0, codes.SETTING_SET)
    assert (state(joined).profile, state(joined).tuned) == ("1.2", False)
    answer(joined, index_of("p1_2_tuned"), 1, codes.SETTING_SET)
    assert state(joined).tuned is True
    answer(joined, index_of("neutral_turn_count"), 172, codes.SETTING_SET_NEUTRAL)
    assert state(joined).settings["neutral_turn_count"] == 172


def test_defaults_and_a_new_session_ask_anew(joined: Any) -> None:
    all_answered(joined, profile=2, p3_1_tuned=1)
    answer(joined, 0, 0, codes.SETTING_DEFAULTS)
    assert state(joined).tuned is None
    joined.turn()
    assert requested(joined) == [index_of(KNOWN[0])]
    joined.board.restart()
    joined.say(joined.board.hello())
    joined.turn(10)
    assert set(requested(joined)) <= {RELAY}


def test_they_are_asked_though_somebody_asked_for_one_before(joined: Any) -> None:
    answer(joined, index_of("profile"), 2)
    answer(joined, RELAY, 1)
    joined.board.received.clear()
    for name in KNOWN[1:]:
        joined.turn()
        assert requested(joined) == [index_of(name)]
        answer(joined, index_of(name), 0)
    joined.turn(1000)
    assert requested(joined) == []
    assert state(joined).tuned is False
