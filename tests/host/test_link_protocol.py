"""The host's side of the wire: handshake, repeats, time to live, orders; in virtual time."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gazechair.board_state import BoardState, BoardStats
from gazechair.link_protocol import (
    Event,
    FaultText,
    LinkProtocol,
    Pong,
    SessionBegun,
    SessionEnded,
    VersionDiffers,
)
from gazechair.outgoing import Clearance, Command
from gazelink import codes, frame, messages

FORWARD = Command(codes.FORWARD, codes.CONTINUOUS, 7, codes.DRIVER, 100.3)


class Line:
    """A protocol and a board joined without loss; time moves only when told."""

    def __init__(self, board: Any) -> None:
        self.board = board
        self.now_s = 100.0
        self.protocol = LinkProtocol()
        self.protocol.opened(self.now_s)
        self.events: list[Event] = []

    def turn(self, ms: int = 0) -> list[Event]:
        """Let `ms` pass, polling each millisecond; the events of that time."""
        new: list[Event] = []
        for step in range(ms + 1):
            if step:
                self.now_s += 0.001
                self.board.stamp_ms = (self.board.stamp_ms + 1) & 0xFFFF
            answer = self.board.receive(self.protocol.poll(self.now_s))
            if step % 10 == 0 and self.board.session:
                answer += self.board.state()
            new += self.protocol.feed(answer, self.now_s)
            new += self.protocol.check(self.now_s)
        self.events += new
        return new

    def say(self, data: bytes) -> list[Event]:
        """The board says `data`."""
        return self.protocol.feed(data, self.now_s)


@pytest.fixture
def line(board: Any) -> Line:
    return Line(board)


@pytest.fixture
def joined(line: Line) -> Line:
    line.turn()
    assert line.protocol.board is not None
    line.board.heard.clear()
    return line


def kinds(events: list[Event]) -> list[type]:
    return [type(event) for event in events]


# Handshake


def test_hello_is_repeated_until_the_board_answers(line: Line) -> None:
    first = line.protocol.poll(100.0)
    assert line.protocol.poll(100.1) == b""
    second = line.protocol.poll(100.2)
    line.board.receive(first + second)
    hellos = line.board.take("hello")
    assert [hello["role"] for hello in hellos] == [0, 0]
    assert hellos[0]["session"] == hellos[1]["session"] != 0
    assert hellos[0]["schema_hash"] == frame.schema_hash()


def test_session_begins_with_the_boards_echo(line: Line) -> None:
    line.board.flags = 1
    begun = [event for event in line.turn() if isinstance(event, SessionBegun)]
    assert len(begun) == 1
    assert begun[0].board.simulated
    assert (begun[0].board.name, begun[0].board.boot) == ("fake", line.board.boot)
    assert begun[0].board.session == line.board.session


def test_a_hello_without_our_session_is_no_answer(line: Line) -> None:
    line.protocol.poll(100.0)
    assert line.say(line.board.hello()) == []
    assert line.protocol.board is None


def test_an_echoing_device_is_no_board(line: Line) -> None:
    assert line.say(line.protocol.poll(100.0)) == []
    assert line.protocol.board is None


def test_another_version_gives_no_session_and_says_so(line: Line) -> None:
    line.board.schema_hash ^= 1
    events = line.turn(500)
    assert set(kinds(events)) == {VersionDiffers}
    assert len(events) == 3  # one for each HELLO: at 0, 200 and 400 ms
    text = events[0].detail  # type: ignore[union-attr]
    assert "flash the board" in text
    assert "\n" not in text
    assert not line.board.take("command")


@pytest.mark.parametrize("echo", [False, True])
def test_a_restarted_board_gets_a_new_session(joined: Line, echo: bool) -> None:
    old = joined.board.session
    joined.board.restart()
    if echo:  # the board drew another boot id, but answers a late HELLO of the old session
        joined.board.session = old
    assert kinds(joined.say(joined.board.hello())) == [SessionEnded]
    assert SessionBegun in kinds(joined.turn())
    assert joined.board.session not in (0, old)


def test_a_board_that_dropped_the_session_gets_a_new_one(joined: Line) -> None:
    old = joined.board.session
    joined.board.session = 0
    assert kinds(joined.say(joined.board.hello())) == [SessionEnded]
    joined.turn()
    assert joined.board.session not in (0, old)


def test_a_late_answer_to_the_same_hello_changes_nothing(joined: Line) -> None:
    assert joined.say(joined.board.hello()) == []
    assert joined.protocol.board is not None


def test_silence_ends_the_session_and_hellos_go_on(joined: Line) -> None:
    joined.now_s += 1.001
    assert kinds(joined.protocol.check(joined.now_s)) == [SessionEnded]
    joined.board.receive(joined.protocol.poll(joined.now_s))
    assert len(joined.board.take("hello")) == 1


def test_frames_of_an_earlier_session_do_not_count(joined: Line) -> None:
    late = joined.board.state(status=codes.ARMED)
    joined.protocol.opened(joined.now_s)
    joined.turn()
    before = joined.protocol.rx_corrupt
    assert joined.say(late) == []
    assert joined.protocol.rx_corrupt == before + 1


# Telemetry


def test_state_is_decoded(joined: Line) -> None:
    joined.board.stamp_ms = 4711
    frame_bytes = joined.board.state(
        status=codes.ARMED | codes.TURNING << 4,
        override=codes.OBSTACLE_LEFT,
        arm_reason=codes.FAULT_REASON + codes.TILT,
        faults=1 << codes.HEADING_JUMP,
        heading_q4_deg=90 * 16 + 8,
        linear_wiper=171,
        turn_wiper=254,
        edge=9,
        decisions=codes.BLOCKED << 2 | codes.UNKNOWN << 4 | codes.SLOW << 6,
    )
    (state,) = joined.say(frame_bytes)
    assert isinstance(state, BoardState)
    assert (state.state_name, state.motion_name) == ("armed", "turn")
    assert (state.override_name, state.arm_reason_name) == ("obstacle_left", "tilt")
    assert (state.heading_deg, state.heading_known) == (90.5, False)
    assert (state.linear_wiper, state.turn_wiper, state.edge) == (171, 254, 9)
    assert state.decision_names == {
        "forward": "free",
        "backward": "blocked",
        "left": "unknown",
        "right": "slow",
    }
    assert (state.board_ms, state.received_s) == (4711, joined.now_s)


def test_numbers_of_a_newer_board_have_names_too(joined: Line) -> None:
    (state,) = joined.say(joined.board.state(status=0x99, override=250))
    assert isinstance(state, BoardState)
    assert (state.state_name, state.motion_name) == ("unknown_9", "unknown_9")
    assert state.override_name == "unknown_250"


def test_statistics_and_fault_texts_are_passed_on(joined: Line) -> None:
    (stats,) = joined.say(joined.board.stats(rx_ok=12))
    assert isinstance(stats, BoardStats)
    assert stats.counters["rx_ok"] == 12
    (fault,) = joined.say(joined.board.fault(codes.FAULT_REASON + codes.WIPER, b"RDAC1 \xff"))
    assert isinstance(fault, FaultText)
    assert (fault.reason, fault.detail) == ("wiper", "RDAC1 \ufffd")


def test_ping_measures_the_round_trip(joined: Line) -> None:
    joined.protocol.request_ping()
    answer = joined.board.receive(joined.protocol.poll(joined.now_s))
    joined.now_s += 0.004
    (pong,) = joined.say(answer)
    assert isinstance(pong, Pong)
    assert pong.round_trip_s == pytest.approx(0.004)
    assert joined.say(answer) == []  # a pong counts once


# Commands


def test_without_a_wish_stop_is_repeated_every_20_ms(joined: Line) -> None:
    joined.turn(1000)
    commands = joined.board.take("command")
    assert 49 <= len(commands) <= 51
    assert {command["verb"] for command in commands} == {codes.STOP}


def test_a_changed_command_is_due_at_once(joined: Line) -> None:
    joined.turn(5)
    joined.board.heard.clear()
    joined.protocol.command(FORWARD, joined.now_s)
    assert joined.protocol.due_s() <= joined.now_s
    joined.turn()
    (command,) = joined.board.take("command")
    assert (command["verb"], command["mode"], command["edge"]) == (1, codes.CONTINUOUS, 7)
    assert command["owner"] == codes.DRIVER
    assert command["ttl_ms"] in (294, 295)


def test_a_refreshed_proof_waits_for_the_next_repeat(joined: Line) -> None:
    joined.protocol.command(FORWARD, joined.now_s)
    joined.turn()
    joined.board.heard.clear()
    refreshed = Command(codes.FORWARD, codes.CONTINUOUS, 7, codes.DRIVER, 100.4)
    joined.protocol.command(refreshed, joined.now_s)
    joined.turn()
    assert not joined.board.take("command")


def test_time_to_live_counts_down_to_0_and_the_last_command_stays(joined: Line) -> None:
    joined.protocol.command(FORWARD, joined.now_s)
    joined.turn(400)
    commands = joined.board.take("command")
    left_ms = [command["ttl_ms"] for command in commands]
    assert left_ms == sorted(left_ms, reverse=True)
    assert (left_ms[0], left_ms[-1]) == (299, 0)
    assert {command["edge"] for command in commands} == {7}


def test_time_to_live_never_exceeds_300_ms(joined: Line) -> None:
    joined.protocol.command(Command(codes.LEFT, codes.STEP, 1, codes.DRIVER, 200.0), 100.0)
    joined.turn()
    assert joined.board.take("command")[0]["ttl_ms"] == 300


def test_every_frame_up_carries_the_newest_stamp_heard(joined: Line) -> None:
    joined.turn(300)
    joined.board.stamp_ms = 5
    joined.say(joined.board.state())
    joined.board.stamps.clear()
    joined.protocol.command(FORWARD, joined.now_s)
    joined.board.receive(joined.protocol.poll(joined.now_s))
    assert joined.board.stamps == [5]


def test_nothing_but_hello_leaves_without_a_session(line: Line) -> None:
    line.protocol.command(FORWARD, line.now_s)
    line.protocol.order(codes.ARM, codes.DRIVER, line.now_s)
    line.protocol.clearance(Clearance(0, codes.REAL, line.now_s), line.now_s)
    line.protocol.request_ping()
    line.board.receive(line.protocol.poll(line.now_s))
    assert [name for name, _ in line.board.heard] == ["hello"]


# Clearance


def test_clearance_leaves_at_once_and_ages_every_50_ms(joined: Line) -> None:
    joined.protocol.clearance(Clearance(5, codes.SIMULATED, joined.now_s - 0.01), joined.now_s)
    joined.turn(200)
    sent = joined.board.take("clearance")
    assert [row["age_ms"] for row in sent] == pytest.approx([10, 60, 110, 160, 210], abs=2)
    assert {(row["blocked"], row["source"]) for row in sent} == {(5, codes.SIMULATED)}


def test_the_age_of_a_forgotten_scan_saturates(joined: Line) -> None:
    joined.protocol.clearance(Clearance(0, codes.REAL, joined.now_s - 1000), joined.now_s)
    joined.turn()
    assert joined.board.take("clearance")[0]["age_ms"] == 65535


# Orders


def test_an_order_is_repeated_for_200_ms_under_one_number(joined: Line) -> None:
    joined.protocol.order(codes.ARM, codes.DRIVER, joined.now_s)
    joined.turn(400)
    orders = joined.board.take("order")
    assert 10 <= len(orders) <= 11
    assert len({order["number"] for order in orders}) == 1
    assert {(order["action"], order["owner"]) for order in orders} == {(codes.ARM, 1)}


def test_order_numbers_differ_and_skip_0(joined: Line) -> None:
    numbers = []
    for _ in range(600):
        joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
        joined.board.receive(joined.protocol.poll(joined.now_s))
        numbers.append(joined.board.take("order")[0]["number"])
    assert 0 not in numbers
    assert all(a != b for a, b in itertools.pairwise(numbers))


def test_a_newer_order_replaces_the_older(joined: Line) -> None:
    joined.protocol.order(codes.ARM, codes.DRIVER, joined.now_s)
    joined.turn(40)
    joined.board.heard.clear()
    joined.protocol.order(codes.DISARM, codes.DRIVER, joined.now_s)
    joined.turn(400)
    assert {order["action"] for order in joined.board.take("order")} == {codes.DISARM}


def test_nothing_replaces_an_emergency_stop_until_the_board_confirms_it(joined: Line) -> None:
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


def test_an_order_given_before_the_session_is_not_kept_for_later(line: Line) -> None:
    line.protocol.order(codes.ARM, codes.DRIVER, line.now_s)
    line.now_s += 1
    line.turn(300)
    assert line.protocol.board is not None
    assert not line.board.take("order")


# Any bytes at all


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(chunks=st.lists(st.binary(max_size=80), max_size=10))
def test_no_bytes_make_it_raise_or_begin_a_session(chunks: list[bytes]) -> None:
    protocol = LinkProtocol()
    protocol.opened(0.0)
    for chunk in chunks:
        assert not any(isinstance(event, SessionBegun) for event in protocol.feed(chunk, 0.0))
    assert protocol.poll(10.0)


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(garbage=st.binary(max_size=200))
def test_after_garbage_the_next_but_one_frame_is_heard(
    new_board: Callable[[], Any], garbage: bytes
) -> None:
    line = Line(new_board())
    line.turn()
    line.say(garbage)
    line.say(line.board.state(edge=1))
    states = [
        event for event in line.say(line.board.state(edge=2)) if isinstance(event, BoardState)
    ]
    assert states[-1].edge == 2


def test_a_message_for_the_board_is_ignored_by_the_host(joined: Line) -> None:
    encoder = frame.Encoder()
    encoder.seed = frame.session_seed(joined.board.session, joined.board.boot)
    messages.COMMAND.pack(encoder.body, (1, 1, 1, 1, 300, 0, 0))
    size = encoder.finish(messages.COMMAND, 0)
    assert joined.say(bytes(encoder.wire[:size])) == []
