"""Handshake and telemetry on the host's side of the wire, in virtual time; any bytes at all."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.board.events import (
    Event,
    FaultText,
    Pong,
    SessionBegun,
    SessionEnded,
    VersionDiffers,
)
from gazechair.board.protocol import TRACE_PERIOD_S, LinkProtocol
from gazechair.board.state import BoardState, BoardStats
from gazelink import codes, frame, messages
from gazesim.board_limits import LIMITS

FORWARD = Command(codes.FORWARD, codes.CONTINUOUS, 7, codes.DRIVER, 100.3)


def kinds(events: list[Event]) -> list[type]:
    return [type(event) for event in events]


# Handshake


def test_hello_is_repeated_until_the_board_answers(line: Any) -> None:
    first = line.protocol.poll(100.0)
    assert line.protocol.poll(100.1) == b""
    second = line.protocol.poll(100.2)
    line.board.receive(first + second)
    hellos = line.board.take("hello")
    assert [hello["role"] for hello in hellos] == [0, 0]
    assert hellos[0]["session"] == hellos[1]["session"] != 0
    assert hellos[0]["schema_hash"] == frame.schema_hash()


def test_session_begins_with_the_boards_echo(line: Any) -> None:
    line.board.flags = 1
    begun = [event for event in line.turn() if isinstance(event, SessionBegun)]
    assert len(begun) == 1
    assert begun[0].board.simulated
    assert (begun[0].board.name, begun[0].board.boot) == ("fake", line.board.boot)
    assert begun[0].board.session == line.board.session


def test_no_session_before_the_boards_nonce(line: Any) -> None:
    line.board.receive(line.protocol.poll(line.now_s))
    assert line.say(line.board.hello()) == []
    assert line.protocol.board is None
    assert line.protocol.poll(line.now_s + 0.1) == b""  # nothing but HELLOs until then
    line.board.session ^= 1
    assert line.say(line.board.nonce_frame()) == []
    line.board.session ^= 1
    assert line.say(line.board.nonce_frame()) == []
    assert line.say(line.board.state()) == []
    assert line.protocol.board is None
    assert line.protocol.poll(line.now_s + 0.1) == b""  # nor until it knows the board's limits
    assert kinds(line.say(line.board.limits_frame())) == [SessionBegun]
    assert line.protocol.board.limits == LIMITS


def test_a_nonce_before_its_hello_waits_for_the_next_hello(line: Any) -> None:
    line.board.receive(line.protocol.poll(line.now_s))
    assert line.say(line.board.nonce_frame()) == []
    rest = line.board.nonce_frame() + line.board.limits_frame()
    assert kinds(line.say(line.board.hello() + rest)) == [SessionBegun]


def test_a_session_begun_anew_by_the_board_is_begun_anew_by_the_host(joined: Any) -> None:
    old = joined.board.session
    assert joined.say(joined.board.nonce_frame()) == []  # the one that is known
    joined.board.nonce = b"anew"
    assert kinds(joined.say(joined.board.nonce_frame())) == [SessionEnded]
    assert SessionBegun in kinds(joined.turn())
    assert joined.board.session not in (0, old)


def test_a_host_goes_on_for_many_rounds_of_the_stamp(joined: Any) -> None:
    for _ in range(20):
        joined.board.stamp_ms = (joined.board.stamp_ms + 20_000) & 0xFFFF
        assert len(joined.say(joined.board.state())) == 1
        joined.board.received.clear()
        joined.protocol.command(FORWARD, joined.now_s)
        joined.protocol.command(STOP_COMMAND, joined.now_s)
        joined.board.receive(joined.protocol.poll(joined.now_s))
        assert joined.board.take("command"), "the board understands it"
    assert joined.board._keys.epoch > 5


def test_a_hello_without_our_session_is_no_answer(line: Any) -> None:
    line.protocol.poll(100.0)
    assert line.say(line.board.hello()) == []
    assert line.protocol.board is None


def test_an_echoing_device_is_no_board(line: Any) -> None:
    assert line.say(line.protocol.poll(100.0)) == []
    assert line.protocol.board is None


def test_another_version_gives_no_session_and_says_so(line: Any) -> None:
    line.board.schema_hash ^= 1
    events = line.turn(500)
    assert set(kinds(events)) == {VersionDiffers}
    assert len(events) == 3  # one for each HELLO: at 0, 200 and 400 ms
    text = events[0].detail  # type: ignore[union-attr]
    assert "flash the board" in text
    assert "\n" not in text
    assert not line.board.take("command")


@pytest.mark.parametrize("echo", [False, True])
def test_a_restarted_board_gets_a_new_session(joined: Any, echo: bool) -> None:
    old = joined.board.session
    joined.board.restart()
    if echo:  # the board drew another boot id, but answers a late HELLO of the old session
        joined.board.session = old
    assert kinds(joined.say(joined.board.hello())) == [SessionEnded]
    assert SessionBegun in kinds(joined.turn())
    assert joined.board.session not in (0, old)


def test_a_board_that_dropped_the_session_gets_a_new_one(joined: Any) -> None:
    old = joined.board.session
    joined.board.session = 0
    assert kinds(joined.say(joined.board.hello())) == [SessionEnded]
    joined.turn()
    assert joined.board.session not in (0, old)


def test_a_late_answer_to_the_same_hello_changes_nothing(joined: Any) -> None:
    assert joined.say(joined.board.hello()) == []
    assert joined.protocol.board is not None


def test_silence_ends_the_session_and_hellos_go_on(joined: Any) -> None:
    joined.now_s += 1.001
    assert kinds(joined.protocol.check(joined.now_s)) == [SessionEnded]
    joined.board.receive(joined.protocol.poll(joined.now_s))
    assert len(joined.board.take("hello")) == 1


def test_frames_of_an_earlier_session_do_not_count(joined: Any) -> None:
    late = joined.board.state(status=codes.ARMED)
    joined.protocol.opened(joined.now_s)
    joined.turn()
    before = joined.protocol.rx_corrupt
    assert joined.say(late) == []
    assert joined.protocol.rx_corrupt == before + 1


# Telemetry


def test_state_is_decoded(joined: Any) -> None:
    joined.board.stamp_ms = 4711
    frame_bytes = joined.board.state(
        status=codes.ARMED | codes.TURNING << 4,
        override=codes.OBSTACLE_LEFT,
        arm_reason=codes.FAULT_REASON + codes.TILT,
        faults=1 << codes.HEADING_JUMP,
        heading_q4_deg=90 * 16 + 8,
        linear_permille=12,
        turn_permille=-1000,
        edge=9,
        decisions=codes.BLOCKED << 2 | codes.UNKNOWN << 4 | codes.SLOW << 6,
    )
    (state,) = joined.say(frame_bytes)
    assert isinstance(state, BoardState)
    assert (state.state_name, state.motion_name) == ("armed", "turn")
    assert (state.override_name, state.arm_reason_name) == ("obstacle_left", "tilt")
    assert (state.heading_deg, state.heading_known) == (90.5, False)
    assert (state.linear_permille, state.turn_permille, state.edge) == (12, -1000, 9)
    assert state.decision_names == {
        "forward": "free",
        "backward": "blocked",
        "left": "unknown",
        "right": "slow",
    }
    assert (state.board_ms, state.received_s) == (4711, joined.now_s)


def test_numbers_of_a_newer_board_have_names_too(joined: Any) -> None:
    (state,) = joined.say(joined.board.state(status=0x99, override=250))
    assert isinstance(state, BoardState)
    assert (state.state_name, state.motion_name) == ("unknown_9", "unknown_9")
    assert state.override_name == "unknown_250"


def test_statistics_and_fault_texts_are_passed_on(joined: Any) -> None:
    (stats,) = joined.say(joined.board.stats(rx_ok=12))
    assert isinstance(stats, BoardStats)
    assert stats.counters["rx_ok"] == 12
    (fault,) = joined.say(joined.board.fault(codes.FAULT_REASON + codes.WIPER, b"RDAC1 \xff"))
    assert isinstance(fault, FaultText)
    assert (fault.reason, fault.detail) == ("wiper", "RDAC1 \ufffd")


def test_the_caretakers_clear_reaches_a_board_that_does_not_start(line: Any) -> None:
    reason = codes.FAULT_REASON + codes.WATCHDOG_BOOTS
    line.protocol.order(codes.RESET_FAULTS, codes.CARETAKER, 100.0)  # nothing to clear yet
    assert b"".join(maintenance(line.protocol.poll(100.0))) == b""
    line.say(line.board.fault(reason, b"3 watchdog resets"))
    line.protocol.order(codes.DISARM, codes.DRIVER, 100.05)
    line.protocol.order(codes.RESET_FAULTS, codes.CARETAKER, 100.1)
    (cleared,) = maintenance(line.protocol.poll(100.1))
    fields = messages.MAINTENANCE.unpack(cleared)
    assert (fields["key"], fields["reason"]) == (messages.MAINTENANCE_KEY, reason)
    assert maintenance(line.protocol.poll(101.0)) == []  # once, until it says so again


@pytest.mark.parametrize("pressed", [False, True], ids=["before", "in between"])
def test_a_clear_is_for_the_port_on_which_the_board_spoke(line: Any, pressed: bool) -> None:
    """A board that came back may start by now: a frame meant to clear opens nothing there."""
    line.say(line.board.fault(codes.FAULT_REASON + codes.WATCHDOG_BOOTS, b"3 watchdog resets"))
    if pressed:
        line.protocol.order(codes.RESET_FAULTS, codes.CARETAKER, 100.1)
    line.protocol.opened(100.2)
    if not pressed:
        line.protocol.order(codes.RESET_FAULTS, codes.CARETAKER, 100.3)
    assert maintenance(line.protocol.poll(100.3)) == []


def maintenance(data: bytes) -> list[bytes]:
    """The MAINTENANCE frames among what was sent."""
    decoder = frame.Decoder()
    whole = [bytes(decoder.buf) for byte in data if decoder.feed(byte)]
    return [buf for buf in whole if buf[messages.TYPE_AT] == messages.MAINTENANCE.type_id]


def test_ping_measures_the_round_trip(joined: Any) -> None:
    joined.protocol.request_ping()
    answer = joined.board.receive(joined.protocol.poll(joined.now_s))
    joined.now_s += 0.004
    (pong,) = joined.say(answer)
    assert isinstance(pong, Pong)
    assert pong.round_trip_s == pytest.approx(0.004)
    assert joined.say(answer) == []  # a pong counts once


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
    new_line: Callable[[], Any], garbage: bytes
) -> None:
    line = new_line()
    line.turn()
    line.say(garbage)
    line.say(line.board.state(edge=1))
    states = [
        event for event in line.say(line.board.state(edge=2)) if isinstance(event, BoardState)
    ]
    assert states[-1].edge == 2


def test_a_message_for_the_board_is_ignored_by_the_host(joined: Any) -> None:
    encoder = frame.Encoder()
    encoder.session = joined.board._keys
    messages.COMMAND.pack(encoder.body, (1, 1, 1, 1, 300, 0, 0, 1000, 0))
    size = encoder.finish(messages.COMMAND, 0)
    assert joined.say(bytes(encoder.wire[:size])) == []


def test_a_trace_is_asked_for_at_once_and_a_snapshot_again_and_again(line: Any) -> None:
    line.turn(100)
    assert line.board.take("trace_request") == []
    line.protocol = LinkProtocol(traced=True)
    line.protocol.opened(line.now_s)
    line.turn(100)
    assert line.board.take("trace_request") == [{"on": 1}]
    line.turn(int(1000 * TRACE_PERIOD_S))
    assert line.board.take("trace_request") == [{"on": 1}]
    line.protocol.opened(line.now_s)
    line.turn(10)
    assert line.board.take("trace_request") == [{"on": 1}]


def test_a_witness_sees_every_frame_of_both_ways(new_line: Callable[[], Any]) -> None:
    line = new_line()
    seen: list[tuple[str, float, bytes]] = []
    line.protocol.witness = lambda *frame: seen.append(frame)
    line.turn()
    line.protocol.command(FORWARD, line.now_s)
    line.turn(100)
    up = [body for way, _, body in seen if way == "up"]
    down = [body for way, _, body in seen if way == "down"]
    assert {body[messages.TYPE_AT] for body in up} >= {
        messages.HELLO.type_id,
        messages.COMMAND.type_id,
    }
    states = [body for body in down if body[messages.TYPE_AT] == messages.STATE.type_id]
    assert len(states) == 1 + 10 + 1
    assert len(states[0]) == messages.STATE.size
    commands = [body for body in up if body[messages.TYPE_AT] == messages.COMMAND.type_id]
    assert messages.COMMAND.unpack(commands[-1])["verb"] == codes.FORWARD
    times_s = [at_s for _, at_s, _ in seen]
    assert times_s == sorted(times_s)
    count = len(seen)
    line.say(b"\x05garbage\x00")
    assert len(seen) == count
