"""P12 end to end: damaged, replayed and foreign frames on a line that carries real traffic."""

from __future__ import annotations

import random

import pytest

from e2e import states
from e2e.damage import KINDS, damage
from gazeboard.core import limits
from gazelink import codes, frame, messages
from gazesim.lockstep_chair import Lockstep
from gazesim.lockstep_host import Host
from gazesim.small_host import clearance
from promises import END_TO_END, kept, measured

pytestmark = pytest.mark.costly


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.1, 0.6, 1.0])
def test_p12_damage_never_moves_a_chair_at_rest(kind: str, share: float) -> None:
    chair = Lockstep()
    chair.cable.to_board.mangle = chair.cable.to_host.mangle = damage(kind, share)
    chair.stays_still(2500)
    chair.cable.to_board.mangle = chair.cable.to_host.mangle = None
    chair.drive(ms=100)
    chair.page.release()
    chair.until(chair.neutral, 5)
    chair.cable.to_board.mangle = chair.cable.to_host.mangle = damage(kind, share, seed=2)
    chair.stays_still(2500)  # with frames of the drive on its heels
    kept(END_TO_END, "P12", f"frames: {kind}")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.05, 0.5])
def test_p12_damage_while_driving_ends_or_leaves_the_press(kind: str, share: float) -> None:
    chair = states.driving()
    chair.cable.to_board.mangle = chair.cable.to_host.mangle = damage(kind, share)
    interrupted = False
    for _ in range(2000):
        chair.one_ms()
        if chair.neutral():
            interrupted = True
        elif interrupted:
            raise AssertionError(f"the same press moves again: {chair.why()}")
    chair.page.release()  # says so even over a bad line: a stop is repeated every 20 ms
    released_ms = chair.now_ms
    chair.until(chair.neutral, 300)
    if not interrupted:
        cause = f"stop over a damaged line ({kind})"
        measured(END_TO_END, "P12", cause, chair.now_ms - released_ms, limits.COMMAND_TTL_MS)
    chair.cable.to_board.mangle = chair.cable.to_host.mangle = None
    chair.run(1500)
    chair.needs_a_new_press()


@pytest.mark.parametrize("late_ms", [30, 90, 110, 300, 2000])
def test_p12_a_delayed_line(late_ms: int) -> None:
    chair = states.driving()
    pressed_ms = chair.now_ms
    chair.cable.to_board.delay_ms = late_ms
    chair.page.forget_button()  # no stop either: only what is already said is on its way
    chair.until(chair.neutral, 600)
    assert chair.now_ms - pressed_ms <= limits.COMMAND_TTL_MS
    chair.stays_still(late_ms + 1000)
    chair.cable.to_board.delay_ms = 0
    chair.needs_a_new_press()


def test_p12_a_recording_of_a_whole_drive_moves_nothing() -> None:
    chair = Lockstep()
    chair.cable.to_board.seen = recording = []
    chair.drive()
    chair.page.press("left")
    chair.run(500)
    chair.page.release()
    chair.cable.to_board.seen = None
    chair.until(chair.neutral, 5)
    commands = b"".join(recording)[-6000:]
    stale = chair.board.app.link.incoming.stale
    for wait_ms in (1, 40, 99, 101, 1000):
        for at in range(0, len(commands), 90):  # at the pace at which the board reads
            chair.cable.to_board.inject(commands[at : at + 90])
            chair.stays_still(1)
        chair.stays_still(wait_ms)
    assert chair.board.app.link.incoming.stale > stale
    chair.cable.pull()  # in another session
    chair.stays_still(5)
    chair.cable.plug()
    chair.arm()
    chair.stays_still(100)
    for at in range(0, len(commands), 90):
        chair.cable.to_board.inject(commands[at : at + 90])
        chair.stays_still(1)
    chair.stays_still(2000)  # its HELLO may have ended the session: a new one begins by itself
    chair.needs_a_new_press()
    kept(END_TO_END, "P12", "a whole drive replayed, in its session and in the next")


def test_p12_two_hosts_on_one_line(driving: Lockstep) -> None:
    other = Host(driving.cable, [lambda request: None], driving.now_s)
    moved_after_ms = 0
    for ms in range(4000):  # both write, and take the answers from each other
        driving.one_ms()
        other.one_ms(driving.now_ms)
        if not driving.harmless():
            moved_after_ms = ms
    assert moved_after_ms < limits.HOST_SILENT_MS + 200  # the other's HELLO ends the session
    assert not driving.armed()
    driving.stays_still(600)
    driving.until(driving.connected, 3000)  # the other one has gone
    driving.needs_a_new_press()
    kept(END_TO_END, "P12", "two hosts on one line")


def test_p12_a_hello_of_another_version_begins_nothing(chair: Lockstep) -> None:
    chair.arm()
    encoder = frame.Encoder()
    values = (0, 0, frame.schema_hash() ^ 1, 0x7777, 0, 9, 9, 9, b"newer")
    for _ in range(20):
        messages.HELLO.pack(encoder.body, values)
        chair.cable.to_board.inject(bytes(encoder.wire[: encoder.finish(messages.HELLO, 0)]))
        chair.stays_still(50)
    assert chair.armed()  # the session goes on
    kept(END_TO_END, "P12", "HELLO of another version")


@pytest.mark.parametrize("per_ms", [20, 96, 300])
def test_p12_a_flood(driving: Lockstep, per_ms: int) -> None:
    noise = random.Random(1)
    line = driving.cable.to_board
    interrupted = False
    for _ in range(1500):
        if line.room():
            line.inject(noise.randbytes(min(per_ms, line.room())))
        driving.one_ms()
        if driving.neutral():
            interrupted = True
        elif interrupted:
            raise AssertionError(driving.why())
    driving.page.release()
    driving.until(driving.neutral, 200)
    driving.stays_still(500)
    driving.needs_a_new_press()
    assert driving.board.watchdog_bites == 0
    kept(END_TO_END, "P12", "a flood of noise on the line")


def test_p12_orders_and_commands_of_a_foreign_session_are_ignored(chair: Lockstep) -> None:
    chair.arm()
    assert chair.host is not None
    board = chair.host.link.board()
    assert board is not None
    stamp = chair.board.app.outbox.ticks & 0xFFFF
    stranger = frame.Encoder()
    stranger.session = frame.Session()
    # It knows all but the nonce.
    stranger.session.begin(board.session, board.boot, b"none", 0, stamp)
    for _ in range(50):
        for message, values in (
            (
                messages.COMMAND,
                (codes.FORWARD, codes.CONTINUOUS, 99, codes.DRIVER, 300, 0, 0, 1000, 0),
            ),
            (messages.ORDER, (codes.DISARM, 99, codes.DRIVER)),
            (messages.CLEARANCE, clearance(15, codes.SIMULATED, 0)),
        ):
            message.pack(stranger.body, values)
            size = stranger.finish(message, stamp)
            chair.cable.to_board.inject(bytes(stranger.wire[:size]))
        chair.stays_still(10)
        stamp += 10
    assert chair.armed()
    kept(END_TO_END, "P12", "frames of a foreign session")
