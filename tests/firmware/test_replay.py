"""P12: recordings of the line, byte for byte, at every time at which they could be taken for new.

The stamps of a recording fit again 65,536 ms later. The oracle sees outputs only: neither the
wipers nor the enable line ever move, whatever is replayed into which session, boot or silence.
"""

import copy
from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import pytest

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazelink import codes, messages
from gazesim.board_rig import Rig
from promises import CORE, kept

# Minutes of the board's life are kept for all of them, by one process.
pytestmark = [pytest.mark.xdist_group("replay"), pytest.mark.costly]

ROUND_MS = 65536
DRIVE_MS = 3500
_ENABLE = at.PINS_AT + pins.ENABLE * at.PIN_SIZE + at.PIN_OUT_COUNT

Recording = list[tuple[int, bytes]]  # ms since power-on, one frame


@cache
def recorded() -> tuple[Rig, Recording]:
    """A board that was armed and driven, then disarmed, and all that its host said to it."""
    rig = Rig()
    frames: Recording = []
    push = rig.wire.push

    def listen(data: Any, n: int) -> None:
        frames.append((rig.now_ms, bytes(data[:n])))
        push(data, n)

    rig.wire.push = listen
    rig.drive()
    rig.run(DRIVE_MS - rig.now_ms)
    assert not rig.neutral()
    del rig.wire.push
    rig.release()
    rig.give(codes.DISARM)
    rig.run(400)
    assert rig.app.safety.state == codes.DISARMED
    return rig, frames


@cache
def later(rounds: int, quiet_ms: int) -> Rig:
    """That board, its host idle all the time and silent at last, as the stamps fit again."""
    if rounds > 1:
        rig = copy.deepcopy(later(rounds - 1, 0))
    else:
        rig = copy.deepcopy(recorded()[0])
    rig.run(rounds * ROUND_MS - rig.now_ms - quiet_ms)
    rig.host_alive = quiet_ms == 0
    rig.run(quiet_ms)
    return rig


def kind(frame: bytes) -> int:
    """Type of a frame on the wire: its first byte is the first of its stuffed body."""
    return frame[1]


def whole(frames: Recording) -> Recording:
    return frames


def without_hello(frames: Recording) -> Recording:
    return [(ms, data) for ms, data in frames if kind(data) != messages.HELLO.type_id]


def only_arming_and_driving(frames: Recording) -> Recording:
    wanted = (messages.ORDER.type_id, messages.COMMAND.type_id, messages.CLEARANCE.type_id)
    return [(ms, data) for ms, data in frames if kind(data) in wanted]


def spliced(frames: Recording) -> Recording:
    """The end of the drive first, then its beginning, then all."""
    half = DRIVE_MS // 2
    shifted = [(ms - half if ms > half else ms + half, data) for ms, data in frames]
    return sorted(shifted, key=lambda row: row[0]) + [(ms + DRIVE_MS, d) for ms, d in frames]


def replay(rig: Rig, frames: Recording, shift_ms: int) -> Iterator[None]:
    """Play the recording into the line, `shift_ms` of the board's time later; each millisecond."""
    waiting = [(ms + shift_ms, data) for ms, data in frames if ms + shift_ms >= rig.now_ms]
    while waiting:
        while waiting and waiting[0][0] <= rig.now_ms:
            data = waiting.pop(0)[1]
            rig.wire.push(data, len(data))
        rig.one_ms()
        yield


def nothing_moves(rig: Rig, frames: Recording, shift_ms: int) -> None:
    toggled = rig.bank[_ENABLE]
    for _ in replay(rig, frames, shift_ms):
        assert rig.neutral(), f"{rig.now_ms} ms: {rig.why()}"
        assert rig.bank[_ENABLE] == toggled, f"{rig.now_ms} ms: {rig.why()}"
    assert rig.app.safety.state == codes.DISARMED


CUTS = (whole, without_hello, only_arming_and_driving, spliced)


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize(
    "quiet_ms",
    [
        pytest.param(0, marks=pytest.mark.recorded),
        pytest.param(120, marks=pytest.mark.long),
        700,
    ],
)
@pytest.mark.parametrize("rounds", [1, pytest.param(2, marks=pytest.mark.recorded)])
def test_p12_a_recording_rounds_of_the_stamp_later(
    cut: Callable[[Recording], Recording], quiet_ms: int, rounds: int
) -> None:
    """In its own session or after it, the true host present, silent for a moment, or dead."""
    frames = cut(recorded()[1])
    for off_ms in (0, 1):
        rig = copy.deepcopy(later(rounds, quiet_ms))
        nothing_moves(rig, frames, rounds * ROUND_MS + off_ms)
    kept(CORE, "P12", "a recording, rounds of the stamp later")


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("host_alive", [False, True])
def test_p12_a_recording_of_the_boot_before(
    cut: Callable[[Recording], Recording], host_alive: bool
) -> None:
    """The clock begins anew, and the rig's board even draws the same boot number again."""
    rig = copy.deepcopy(recorded()[0])
    rig.boot()
    rig.now_ms = 0
    rig.host_alive = host_alive
    nothing_moves(rig, cut(recorded()[1]), 0)
    kept(CORE, "P12", "a recording of the boot before")


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("delay_ms", [0, 7, 60, 99, 101, 400, 3600])
def test_p12_a_recording_at_once(cut: Callable[[Recording], Recording], delay_ms: int) -> None:
    """The last moments of the drive again, right after it, while their stamps are still fresh."""
    rig = copy.deepcopy(recorded()[0])
    rig.host_alive = False
    rig.run(2)
    frames = [row for row in cut(recorded()[1]) if row[0] > DRIVE_MS - 300]
    nothing_moves(rig, frames, rig.now_ms - (DRIVE_MS - 300) + delay_ms)
    kept(CORE, "P12", "a recording, at once")
