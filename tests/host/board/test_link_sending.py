"""Frames to the board: commands and their time to live, clearance, orders. Virtual time."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import pytest

from gazechair.board.board_commands import Bypass, Clearance, Command
from gazelink import codes

FORWARD = Command(codes.FORWARD, codes.CONTINUOUS, 7, codes.DRIVER, 100.3)


# Commands


def test_without_a_command_stop_is_repeated_every_20_ms(joined: Any) -> None:
    joined.turn(1000)
    commands = joined.board.take("command")
    assert 49 <= len(commands) <= 51
    assert {command["verb"] for command in commands} == {codes.STOP}


def test_a_changed_command_is_due_at_once(joined: Any) -> None:
    joined.turn(5)
    joined.board.received.clear()
    joined.protocol.command(FORWARD, joined.now_s)
    assert joined.protocol.due_s() <= joined.now_s
    joined.turn()
    (command,) = joined.board.take("command")
    assert (command["verb"], command["mode"], command["edge"]) == (1, codes.CONTINUOUS, 7)
    assert command["owner"] == codes.DRIVER
    assert command["ttl_ms"] in (294, 295)


def test_a_refreshed_proof_waits_for_the_next_repeat(joined: Any) -> None:
    joined.protocol.command(FORWARD, joined.now_s)
    joined.turn()
    joined.board.received.clear()
    refreshed = Command(codes.FORWARD, codes.CONTINUOUS, 7, codes.DRIVER, 100.4)
    joined.protocol.command(refreshed, joined.now_s)
    joined.turn()
    assert not joined.board.take("command")


def test_time_to_live_counts_down_to_0_and_the_last_command_stays(joined: Any) -> None:
    joined.protocol.command(FORWARD, joined.now_s)
    joined.turn(400)
    commands = joined.board.take("command")
    left_ms = [command["ttl_ms"] for command in commands]
    assert left_ms == sorted(left_ms, reverse=True)
    assert (left_ms[0], left_ms[-1]) == (299, 0)
    assert {command["edge"] for command in commands} == {7}


def test_time_to_live_never_exceeds_300_ms(joined: Any) -> None:
    joined.protocol.command(Command(codes.LEFT, codes.STEP, 1, codes.DRIVER, 200.0), 100.0)
    joined.turn()
    assert joined.board.take("command")[0]["ttl_ms"] == 300


def test_nor_what_this_board_says_it_may_live(line: Any) -> None:
    line.board.limits = replace(line.board.limits, command_ttl_ms=120)
    line.turn()
    line.protocol.command(Command(codes.LEFT, codes.STEP, 1, codes.DRIVER, 200.0), 100.0)
    line.protocol.bypass(Bypass(1, 200.0), 100.0)
    line.board.received.clear()
    line.turn()
    sent = dict(line.board.received)
    assert (sent["command"]["ttl_ms"], sent["bypass"]["ttl_ms"]) == (120, 120)


def test_every_frame_up_carries_the_newest_stamp_heard(joined: Any) -> None:
    joined.turn(300)
    joined.board.stamp_ms = 5000
    joined.say(joined.board.state())
    joined.board.stamp_ms = 4990  # captured earlier, sent later
    joined.say(joined.board.state())
    joined.board.stamps.clear()
    joined.protocol.command(FORWARD, joined.now_s)
    joined.board.receive(joined.protocol.poll(joined.now_s))
    assert joined.board.stamps == [5000]


def test_nothing_but_hello_leaves_without_a_session(line: Any) -> None:
    line.protocol.command(FORWARD, line.now_s)
    line.protocol.order(codes.ARM, codes.DRIVER, line.now_s)
    line.protocol.clearance(Clearance(0, codes.REAL, line.now_s), line.now_s)
    line.protocol.request_ping()
    line.board.receive(line.protocol.poll(line.now_s))
    assert [name for name, _ in line.board.received] == ["hello"]


# Clearance


def test_clearance_leaves_at_once_and_ages_every_50_ms(joined: Any) -> None:
    joined.protocol.clearance(Clearance(5, codes.SIMULATED, joined.now_s - 0.01), joined.now_s)
    joined.turn(200)
    sent = joined.board.take("clearance")
    assert [row["age_ms"] for row in sent] == pytest.approx([10, 60, 110, 160, 210], abs=2)
    assert {(row["blocked"], row["source"]) for row in sent} == {(5, codes.SIMULATED)}


def test_the_age_of_a_forgotten_scan_saturates(joined: Any) -> None:
    joined.protocol.clearance(Clearance(0, codes.REAL, joined.now_s - 1000), joined.now_s)
    joined.turn()
    assert joined.board.take("clearance")[0]["age_ms"] == 65535


# Orders


def test_an_order_is_repeated_for_200_ms_under_one_number(joined: Any) -> None:
    joined.protocol.order(codes.ARM, codes.DRIVER, joined.now_s)
    joined.turn(400)
    orders = joined.board.take("order")
    assert 10 <= len(orders) <= 11
    assert len({order["number"] for order in orders}) == 1
    assert {(order["action"], order["owner"]) for order in orders} == {(codes.ARM, 1)}


def test_order_numbers_differ_and_skip_0(joined: Any) -> None:
    numbers = []
    for _ in range(600):
        joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
        joined.board.receive(joined.protocol.poll(joined.now_s))
        numbers.append(joined.board.take("order")[0]["number"])
    assert 0 not in numbers
    assert all(a != b for a, b in itertools.pairwise(numbers))


def actions(line: Any) -> set[int]:
    return {order["action"] for order in line.board.take("order")}


def test_disarming_ends_the_order_to_arm_given_before_it(joined: Any) -> None:
    joined.protocol.order(codes.ARM, codes.DRIVER, joined.now_s)
    joined.turn(40)
    joined.board.received.clear()
    joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
    joined.turn(400)
    assert actions(joined) == {codes.DISARM}


@pytest.mark.parametrize(
    "newer", [(codes.RESET_FAULTS,), (codes.ARM,), (codes.RESET_FAULTS, codes.ARM)]
)
def test_nothing_takes_the_place_of_disarming(joined: Any, newer: tuple[int, ...]) -> None:
    joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
    for action in newer:
        joined.protocol.order(action, codes.CARETAKER, joined.now_s)
    joined.turn(150)
    assert actions(joined) == {codes.DISARM, *newer}


def test_disarming_is_repeated_until_the_board_is_seen_disarmed(joined: Any) -> None:
    joined.board.status = codes.ARMED
    joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
    joined.turn(400)
    joined.board.received.clear()
    joined.turn(100)
    assert actions(joined) == {codes.DISARM}
    joined.board.status = codes.DISARMED
    joined.turn(30)
    joined.board.received.clear()
    joined.turn(100)
    assert not actions(joined)


def test_disarming_seen_done_early_is_repeated_against_loss_all_the_same(joined: Any) -> None:
    joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
    joined.say(joined.board.state(status=codes.DISARMED))  # it may have been on its way before
    joined.turn(190)
    assert len(joined.board.take("order")) >= 9


def test_a_new_session_drops_all_but_an_emergency_stop(joined: Any) -> None:
    for action in (codes.EMERGENCY_STOP, codes.DISARM):
        joined.protocol.order(action, codes.DRIVER, joined.now_s)
    joined.board.restart()
    joined.say(joined.board.hello())
    joined.board.received.clear()
    joined.turn(100)
    assert actions(joined) == {codes.EMERGENCY_STOP}
    joined.say(joined.board.state(faults=1 << codes.EMERGENCY))
    joined.protocol.order(codes.ARM, codes.DRIVER, joined.now_s)
    joined.board.restart()
    joined.say(joined.board.hello())
    joined.board.received.clear()
    joined.turn(100)
    assert not actions(joined)


def test_nothing_replaces_an_emergency_stop_until_the_board_confirms_it(joined: Any) -> None:
    joined.protocol.order(codes.EMERGENCY_STOP, codes.DRIVER, joined.now_s)
    joined.protocol.order(codes.ARM, codes.DRIVER, joined.now_s)
    joined.turn(500)
    assert {row["action"] for row in joined.board.take("order")} == {codes.EMERGENCY_STOP}
    joined.say(joined.board.state(faults=1 << codes.EMERGENCY))
    joined.turn(100)
    assert not joined.board.take("order")
    joined.protocol.order(codes.RESET_FAULTS, codes.CARETAKER, joined.now_s)
    joined.turn()
    assert joined.board.take("order")[0]["action"] == codes.RESET_FAULTS


def test_an_order_given_before_the_session_is_not_kept_for_later(line: Any) -> None:
    line.protocol.order(codes.ARM, codes.DRIVER, line.now_s)
    line.now_s += 1
    line.turn(300)
    assert line.protocol.board is not None
    assert not line.board.take("order")
