"""What a driver learns about a call for help and a stop: who receives it, if it was confirmed."""

from __future__ import annotations

from dataclasses import replace

import pytest

from controlrig import QUIET, Rig
from gazechair.driving.arbiter import THERE_S
from gazechair.driving.help_call import COMING_S
from gazechair.driving.messages import Beat


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_a_call_that_a_caretaker_answers_is_coming_until_they_are_there(rig: Rig) -> None:
    caretaker = rig.control.connect("caretaker")
    rig.say(k="call", on=True)
    assert rig.look()["coming"] is False
    rig.control.receive(caretaker, {"k": "call", "on": False})
    assert (rig.look()["call"], rig.look()["coming"]) == (False, True)
    rig.control.receive(caretaker, {"k": "call", "on": False, "there": True})
    assert rig.look()["coming"] is False


def test_who_answers_twice_or_after_another_caretaker_still_comes(rig: Rig) -> None:
    caretakers = [rig.control.connect("caretaker") for _ in range(2)]
    rig.say(k="call", on=True)
    for caretaker in (*caretakers, *caretakers):
        sent = {"k": "call", "on": False, "there": False}
        assert rig.control.receive(caretaker, sent) == []
        assert (rig.look()["call"], rig.look()["coming"]) == (False, True)
    rig.now_s += COMING_S + 0.1  # the answers that came later did not make it last
    assert rig.look()["coming"] is False


def test_who_is_there_answers_a_call_made_meanwhile(rig: Rig) -> None:
    caretaker = rig.control.connect("caretaker")
    rig.say(k="call", on=True)
    rig.control.receive(caretaker, {"k": "call", "on": False})
    rig.say(k="call", on=True)
    rig.control.receive(caretaker, {"k": "call", "on": False, "there": True})
    assert (rig.look()["call"], rig.look()["coming"]) == (False, True)


@pytest.mark.parametrize("on", [True, False])
def test_a_driver_calls_anew_or_takes_the_call_back(rig: Rig, on: bool) -> None:
    caretaker = rig.control.connect("caretaker")
    rig.say(k="call", on=True)
    rig.control.receive(caretaker, {"k": "call", "on": False})
    rig.say(k="call", on=on)
    assert (rig.look()["call"], rig.look()["coming"]) == (on, False)


def test_nobody_comes_for_ever(rig: Rig) -> None:
    caretaker = rig.control.connect("caretaker")
    rig.say(k="call", on=True)
    rig.control.receive(caretaker, {"k": "call", "on": False})
    rig.now_s += COMING_S - 0.1
    assert rig.look()["coming"] is True
    rig.now_s += 0.2
    assert rig.look()["coming"] is False


def test_a_call_is_heard_by_a_caretaker_whose_page_lives_and_by_nobody_else(rig: Rig) -> None:
    rig.control.connect("viewer")
    assert rig.look()["heard"] is False
    caretaker = rig.control.connect("caretaker")
    assert rig.look()["heard"] is True
    rig.now_s += THERE_S + 0.1  # its phone sleeps
    assert rig.look()["heard"] is False
    beat = {"k": "hb", "token": rig.control.token(), "since": 0}
    rig.control.receive(caretaker, beat)
    assert rig.look()["heard"] is True
    rig.control.update()
    version = rig.control.wait_change(0.0, -1)
    rig.control.disconnect(caretaker)
    assert rig.look()["heard"] is False
    assert rig.control.wait_change(0.0, version) != version


def test_a_caretaker_s_gamepad_hears_no_call(rig: Rig) -> None:
    gamepad = rig.control.join("caretaker")
    assert rig.control.act(gamepad, Beat(rig.control.proof(rig.now_s))) is None
    assert rig.look()["heard"] is False


def test_a_stop_is_seen_when_the_board_has_said_since_that_it_stands(rig: Rig) -> None:
    def board(motion: int, after_s: float) -> int:
        rig.now_s += after_s
        rig.link.now = replace(QUIET, motion=motion, received_s=rig.now_s)
        rig.control.update()
        return int(rig.look()["stops"])

    assert board(0, 0.0) == 0
    rig.say(k="stop")
    assert board(0, 0.02) == 0  # may have been told before
    assert board(1, 0.1) == 0  # moves on
    assert board(0, 0.02) == 1
    rig.say(k="stop")
    rig.say(k="stop")
    rig.link.now = None  # no board, no word
    rig.now_s += 5.0
    rig.control.update()
    assert rig.look()["stops"] == 1
    assert board(0, 0.02) == 3


def test_a_stop_that_was_seen_is_news_and_only_its_own_pages(rig: Rig) -> None:
    other = rig.control.connect("caretaker")
    rig.control.update()
    version = rig.control.wait_change(0.0, -1)
    rig.say(k="stop")
    rig.now_s += 0.1
    rig.link.now = replace(QUIET, received_s=rig.now_s)
    rig.control.update()
    assert rig.control.wait_change(0.0, version) != version
    assert rig.control.snapshot(other)["stops"] == 0
