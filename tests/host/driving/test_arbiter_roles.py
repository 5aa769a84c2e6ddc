"""What each role may: taking over, giving back, proportional driving, speed cap, bypass."""

from __future__ import annotations

from typing import Any

import pytest

from gazechair.driving.messages import (
    DISARM,
    EMERGENCY,
    END_BYPASS,
    RELEASE,
    STOP,
    Arm,
    Cap,
    Drive,
    HoldBypass,
    Reset,
    Take,
)
from gazelink import codes


@pytest.fixture
def caretaker(armed: Any) -> int:
    page: int = armed.arbiter.connect("caretaker", armed.now_s)
    return page


@pytest.fixture
def viewer(armed: Any) -> int:
    page: int = armed.arbiter.connect("viewer", armed.now_s)
    return page


def pull(scene: Any, page: int, edge: int, linear: int, turn: int = 0) -> str | None:
    message = Drive(codes.DRIVE, codes.CONTINUOUS, edge, scene.token(), linear, turn)
    refusal = scene.say(message, page)
    return None if refusal is None else refusal.reason


# Viewers


@pytest.mark.parametrize("kind", [STOP, DISARM, EMERGENCY, RELEASE, END_BYPASS, Cap(500)])
def test_a_viewer_changes_nothing(armed: Any, viewer: int, kind: object) -> None:
    armed.drive(1)
    refusal = armed.say(kind, viewer)
    assert (refusal.what, refusal.reason) == ("message", "not_allowed")
    assert armed.moving
    assert armed.arbiter.take_orders() == []
    assert armed.arbiter.cap_permille == 1000


def test_a_viewer_cannot_own_or_move(armed: Any, viewer: int) -> None:
    token = armed.token()
    for message in (Arm(token), Take(token), Reset(token), HoldBypass(1, token)):
        assert armed.say(message, viewer).reason == "not_allowed"
    assert armed.drive(1, viewer) == "not_allowed"
    assert armed.arbiter.owner == armed.page


def test_a_viewers_heartbeat_is_not_the_drivers(armed: Any, viewer: int) -> None:
    for _ in range(35):
        armed.wait(0.01, beating=False)
        armed.beat(viewer)
    assert armed.arbiter.page_silent


# Taking over and giving back


def test_a_driver_does_not_take_over_cap_or_bypass(armed: Any) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    token = armed.token()
    for message, what in (
        (Take(token), "take"),
        (Cap(500), "cap"),
        (HoldBypass(1, token), "bypass"),
    ):
        refusal = armed.say(message, other)
        assert (refusal.what, refusal.reason) == (what, "not_allowed")
    assert armed.arbiter.owner == armed.page


def test_the_driver_goes_on_only_after_the_caretaker_gave_the_chair_back(
    armed: Any, caretaker: int
) -> None:
    armed.take(caretaker)
    armed.beat(caretaker)
    assert armed.arm().reason == "not_owner"
    armed.say(RELEASE)  # it is not the driver's to give
    assert armed.arbiter.owner == caretaker
    armed.arbiter.take_orders()
    armed.say(RELEASE, caretaker)
    assert armed.arbiter.take_orders() == [(codes.DISARM, codes.CARETAKER)]
    assert armed.arbiter.owner is None
    assert armed.drive(1) == "not_armed"
    assert armed.arm() is None


def test_one_caretaker_takes_over_from_another(armed: Any, caretaker: int) -> None:
    other = armed.arbiter.connect("caretaker", armed.now_s)
    armed.take(caretaker)
    assert pull(armed, caretaker, 1, 300) is None
    armed.take(other)
    assert armed.verb == codes.STOP
    assert pull(armed, caretaker, 1, 300) == "not_owner"
    assert armed.arbiter.owner == other


def test_a_request_to_take_over_that_was_long_on_its_way_is_refused(
    armed: Any, caretaker: int
) -> None:
    armed.drive(1)
    assert armed.say(Take(armed.token() - 300), caretaker).reason == "stale_token"
    assert armed.moving


def test_without_a_board_nobody_takes_over(armed: Any, caretaker: int) -> None:
    armed.session = 0
    armed.board()
    refusal = armed.take(caretaker)
    assert (refusal.what, refusal.reason) == ("take", "not_connected")


def test_a_caretaker_who_vanishes_leaves_nobody_driving(armed: Any, caretaker: int) -> None:
    armed.take(caretaker)
    pull(armed, caretaker, 1, 300)
    armed.arbiter.take_orders()
    armed.arbiter.disconnect(caretaker)
    assert armed.verb == codes.STOP
    assert armed.arbiter.take_orders() == [(codes.DISARM, codes.CARETAKER)]


# Proportional driving


def test_a_proportional_press_follows_the_stick(armed: Any, caretaker: int) -> None:
    armed.take(caretaker)
    assert pull(armed, caretaker, 1, 300, -20) is None
    first = armed.arbiter.command
    assert (first.verb, first.linear_permille, first.turn_permille) == (codes.DRIVE, 300, -20)
    assert first.owner == codes.CARETAKER
    armed.now_s += 0.05
    assert pull(armed, caretaker, 1, -100, 700) is None
    now = armed.arbiter.command
    assert (now.edge, now.linear_permille, now.turn_permille) == (first.edge, -100, 700)
    assert now.ttl_deadline_s == pytest.approx(armed.now_s + 0.3)


def test_a_stick_let_go_without_a_word_ends_and_needs_a_new_press(
    armed: Any, caretaker: int
) -> None:
    armed.take(caretaker)
    pull(armed, caretaker, 1, 300)
    for _ in range(31):
        armed.wait(0.01, beating=False)
        armed.beat(caretaker)
    assert not armed.moving
    assert pull(armed, caretaker, 1, 300) == "needs_new_command"
    assert pull(armed, caretaker, 2, 300) is None
    assert armed.moving


def test_a_stick_and_a_button_are_different_presses(armed: Any) -> None:
    assert pull(armed, armed.page, 1, 300) is None
    assert armed.drive(1) == "needs_new_command"
    assert armed.verb == codes.STOP


# The speed cap


def test_the_cap_holds_for_everybody_until_it_is_changed(armed: Any, caretaker: int) -> None:
    assert armed.say(Cap(400), caretaker) is None
    assert armed.arbiter.command.cap_permille == 400
    armed.drive(1)
    assert armed.arbiter.command.cap_permille == 400
    armed.arbiter.disconnect(caretaker)
    assert armed.arbiter.command.cap_permille == 400
    armed.take(other := armed.arbiter.connect("caretaker", armed.now_s))
    pull(armed, other, 1, 1000)
    assert armed.arbiter.command.cap_permille == 400
    armed.say(Cap(1000), other)
    assert armed.arbiter.command.cap_permille == 1000
    assert armed.moving


# The bypass


def held(scene: Any, page: int, edge: int, age_ms: int = 0) -> str | None:
    refusal = scene.say(HoldBypass(edge, scene.token() - age_ms), page)
    return None if refusal is None else refusal.reason


def test_a_held_bypass_lives_from_proof_to_proof(armed: Any, caretaker: int) -> None:
    assert armed.arbiter.bypass is None
    assert held(armed, caretaker, 1) is None
    number = armed.arbiter.bypass.number
    for _ in range(10):
        armed.wait(0.1)
        assert held(armed, caretaker, 1) is None
        assert armed.arbiter.bypass.number == number
        assert armed.arbiter.bypass.ttl_deadline_s == pytest.approx(armed.now_s + 0.3)
    armed.wait(0.31)
    assert armed.arbiter.bypass is None


def test_a_bypass_that_ended_needs_a_new_press(armed: Any, caretaker: int) -> None:
    held(armed, caretaker, 1)
    number = armed.arbiter.bypass.number
    armed.say(END_BYPASS, caretaker)
    assert armed.arbiter.bypass is None
    assert held(armed, caretaker, 1) == "needs_new_command"
    assert held(armed, caretaker, 1) is None  # told once
    assert armed.arbiter.bypass is None
    assert held(armed, caretaker, 2) is None
    assert armed.arbiter.bypass.number != number


def test_a_bypass_ends_with_its_caretaker_only(armed: Any, caretaker: int) -> None:
    other = armed.arbiter.connect("caretaker", armed.now_s)
    held(armed, caretaker, 1)
    armed.say(END_BYPASS, other)
    assert armed.arbiter.bypass is not None
    armed.arbiter.disconnect(caretaker)
    assert armed.arbiter.bypass is None


def test_an_old_bypass_message_counts_for_nothing(armed: Any, caretaker: int) -> None:
    assert held(armed, caretaker, 1, age_ms=251) == "stale_token"
    assert armed.arbiter.bypass is None


def test_bypass_numbers_are_never_0_nor_the_last_one(armed: Any, caretaker: int) -> None:
    last = 0
    for edge in range(1, 600):
        held(armed, caretaker, edge)
        assert armed.arbiter.bypass.number not in (0, last)
        last = armed.arbiter.bypass.number
