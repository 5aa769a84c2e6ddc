"""Who may move the chair. Virtual time."""

from __future__ import annotations

from typing import Any

from gazechair.driving.messages import DISARM, EMERGENCY, STOP, Arm, Reset
from gazelink import codes

ARM_ORDER = (codes.ARM, codes.DRIVER)


# Arming and owning


def test_at_first_the_board_is_told_to_stop_and_nobody_drives(scene: Any) -> None:
    assert scene.verb == codes.STOP
    assert scene.arbiter.owner_code == codes.NOBODY


def test_who_arms_owns_the_chair(scene: Any) -> None:
    assert scene.arm() is None
    assert scene.arbiter.take_orders() == [ARM_ORDER]
    assert scene.arbiter.owner == scene.page
    assert scene.arbiter.take_orders() == []


def test_an_order_to_arm_that_the_board_does_not_follow_lapses(scene: Any) -> None:
    scene.arm()
    scene.wait(1.1)
    assert scene.arbiter.owner is None


def test_arming_again_at_once_after_disarming_keeps_the_owner(armed: Any) -> None:
    armed.say(DISARM)
    armed.arm()
    armed.board(codes.DISARMED)  # the board's answer to the first order
    assert armed.arbiter.owner == armed.page
    armed.board(codes.ARMED)
    assert armed.drive(1) is None


def test_without_a_board_arming_is_refused(scene: Any) -> None:
    scene.session = 0
    scene.board()
    refusal = scene.arm()
    assert refusal is not None
    assert (refusal.what, refusal.reason) == ("arm", "not_connected")
    assert scene.arbiter.take_orders() == []


def test_a_second_driver_is_refused_while_the_first_drives(armed: Any) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    refusal = armed.arm(other)
    assert refusal is not None
    assert refusal.reason == "not_owner"
    assert armed.drive(1, other) == "not_owner"
    assert not armed.moving


def test_the_caretaker_takes_over_and_the_driver_stops(armed: Any) -> None:
    armed.drive(1)
    caretaker = armed.arbiter.connect("caretaker", armed.now_s)
    refusal = armed.arm(caretaker)  # arming is no taking over: that is asked for by its own name
    assert refusal is not None
    assert refusal.reason == "not_owner"
    assert armed.moving
    assert armed.take(caretaker) is None
    assert armed.verb == codes.STOP
    assert armed.arbiter.take_orders() == [(codes.ARM, codes.CARETAKER)]
    assert armed.arbiter.owner_code == codes.CARETAKER
    assert armed.drive(1) == "not_owner"
    assert armed.drive(1, caretaker) is None
    assert armed.arbiter.command.owner == codes.CARETAKER


def test_an_owner_who_leaves_stops_and_disarms(armed: Any) -> None:
    armed.drive(1)
    armed.arbiter.disconnect(armed.page)
    assert armed.verb == codes.STOP
    assert armed.arbiter.take_orders() == [(codes.DISARM, codes.DRIVER)]
    assert armed.arbiter.owner is None


def test_another_page_that_leaves_changes_nothing(armed: Any) -> None:
    other = armed.arbiter.connect("driver", armed.now_s)
    armed.drive(1)
    armed.arbiter.disconnect(other)
    armed.arbiter.disconnect(999)
    assert armed.moving
    assert armed.arbiter.take_orders() == []


def test_a_board_that_disarms_has_no_owner_any_more(armed: Any) -> None:
    armed.drive(1)
    armed.board(codes.DISARMED)
    assert armed.arbiter.owner is None
    assert not armed.moving
    assert armed.drive(1) == "not_armed"


# Orders


def test_emergency_and_disarm_are_ordered_for_anyone(scene: Any) -> None:
    scene.say(EMERGENCY)
    scene.say(DISARM)
    assert scene.arbiter.take_orders() == [
        (codes.EMERGENCY_STOP, codes.DRIVER),
        (codes.DISARM, codes.DRIVER),
    ]


def test_only_the_caretaker_resets_faults(scene: Any) -> None:
    refusal = scene.say(Reset(scene.token()))
    assert refusal is not None
    assert (refusal.what, refusal.reason) == ("reset", "not_allowed")
    assert "3 s" in refusal.detail
    assert scene.arbiter.take_orders() == []
    caretaker = scene.arbiter.connect("caretaker", scene.now_s)
    assert scene.say(Reset(scene.token()), caretaker) is None
    assert scene.arbiter.take_orders() == [(codes.RESET_FAULTS, codes.CARETAKER)]


def test_a_reset_sent_before_an_emergency_stop_does_not_clear_it(scene: Any) -> None:
    caretaker = scene.arbiter.connect("caretaker", scene.now_s)
    other = scene.arbiter.connect("driver", scene.now_s)
    sent, late = Reset(scene.token()), Reset(scene.token() - 300)
    scene.now_s += 0.1
    scene.say(EMERGENCY, other)
    scene.arbiter.take_orders()
    for reset in (sent, late):
        refusal = scene.say(reset, caretaker)
        assert refusal is not None
        assert (refusal.what, refusal.reason) == ("reset", "stale_token")
    assert scene.arbiter.take_orders() == []
    scene.now_s += 0.1
    assert scene.say(sent, caretaker) is not None
    assert scene.say(Reset(scene.token()), caretaker) is None
    assert scene.arbiter.take_orders() == [(codes.RESET_FAULTS, codes.CARETAKER)]


def test_a_page_that_is_gone_commands_nothing(armed: Any) -> None:
    armed.arbiter.disconnect(armed.page)
    armed.arbiter.take_orders()
    for message in (STOP, EMERGENCY, DISARM, Arm(armed.token())):
        assert armed.say(message) is not None
    assert armed.drive(1) == "not_owner"
    assert armed.arbiter.take_orders() == []
