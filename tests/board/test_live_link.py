"""A live board on its cable: sessions in any order, nothing but our frames counts, none moves it.

With --board PORT these run on a real Teensy too, its relay held open, or on the simulator's.
"""

import random

import pytest

from gazelink import codes, frame, messages
from liveboard import EmulatedLiveBoard, LiveBoard
from livehost import NEUTRAL_OUTPUT

pytestmark = [pytest.mark.m7, pytest.mark.xdist_group("board")]

_TRIES = 3  # a stall of the PC costs the emulation ticks


def neutral_throughout(board: LiveBoard, since: int = 0) -> None:
    """No state the board ever told since had an output other than neutral."""
    moved = [s for ticks, s in board.host.states if ticks >= since and output(s) != NEUTRAL_OUTPUT]
    assert not moved, moved[:3]


def output(state: dict[str, int]) -> tuple[int, int]:
    return state["linear_permille"], state["turn_permille"]


def test_greets_with_its_name_version_and_table(board: LiveBoard) -> None:
    board.connect()
    hello = board.host.hellos[-1]
    assert hello["role"] == 1
    assert hello["name"].rstrip(b"\0") == b"teensy40"
    assert hello["schema_hash"] == frame.schema_hash()
    assert bool(hello["flags"] & 1) == board.simulated
    assert hello["session"] == board.host.session


def test_a_host_that_talks_while_the_board_boots_does_not_stop_it(
    emulated: EmulatedLiveBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frames hold byte 3, and a HELLO with stamp 0 begins with it."""
    monkeypatch.setattr("livehost.HELLO_S", 0.02)
    emulated.host.connected = False
    # Still sooner than any USB host gives a device its port.
    emulated.until(lambda: emulated.bank.tick_ms >= 20, "the board's first ticks")
    emulated.host.connected = True
    emulated.connect()


def test_tells_its_state_a_hundred_times_a_second(board: LiveBoard) -> None:
    board.connect()
    board.run_ms(300)
    for _ in range(_TRIES):
        first = board.host.ticks
        board.run_ms(1300)
        reported = [ticks for ticks, _ in board.host.states if first < ticks <= first + 1000]
        if len(reported) >= 80:
            break
    # Lossy by design, and the emulation is slower than a Teensy; `gazechair measure` has figures.
    assert len(reported) >= 80, f"by the board's own clock, {_TRIES} times"


def test_starts_neutral_and_disarmed(board: LiveBoard) -> None:
    board.connect()
    assert board.host.safety == codes.DISARMED
    neutral_throughout(board)


def test_another_host_or_the_same_one_again_gets_a_new_session(board: LiveBoard) -> None:
    board.connect()
    boot = board.host.hellos[-1]["boot"]
    for _ in range(3):
        old = board.host.session
        board.host.close()
        board.host.states.clear()
        board.connect()
        assert board.host.session != old
        assert board.host.hellos[-1]["boot"] == boot, "it must not have reset"
        assert board.host.safety == codes.DISARMED


def test_another_version_is_answered_but_gets_no_session(board: LiveBoard) -> None:
    board.connect()
    board.host.close()
    board.host.hellos.clear()
    board.host.wrong_schema = True
    board.until(lambda: len(board.host.hellos) >= 3, "answers to another version")
    assert not board.host.in_session
    assert {hello["schema_hash"] for hello in board.host.hellos} == {frame.schema_hash()}
    board.host.wrong_schema = False
    board.connect()


def test_a_command_before_arming_is_refused_with_the_reason(board: LiveBoard) -> None:
    board.host.hold(codes.FORWARD, board.new_edge())
    board.connect()
    board.until(lambda: board.host.state["override"] == codes.NOT_ARMED, "the reason")
    board.run_ms(300)
    assert board.host.safety == codes.DISARMED
    neutral_throughout(board)


@pytest.mark.parametrize("kind", ["noise", "zeros", "ones", "half_frames", "foreign_session"])
def test_garbage_is_counted_and_never_moves(board: LiveBoard, kind: str) -> None:
    board.connect()
    before = board.host.stats.get("rx_corrupt", 0)
    chance = random.Random(7)
    for _ in range(60):
        board.host.raw(garbage(kind, chance))
        board.pass_time()
    board.run_ms(500)
    board.until(lambda: board.host.stats.get("rx_corrupt", 0) > before, "it counts them")
    assert board.host.safety == codes.DISARMED
    neutral_throughout(board)
    # A session that a stalled machine has cost is made anew by these.
    board.until(lambda: board.host.in_session, "our own frames still count")


def garbage(kind: str, chance: random.Random) -> bytes:
    if kind == "noise":
        return chance.randbytes(chance.randrange(1, 90)) + b"\0"
    if kind == "zeros":
        return bytes(40) + b"\x01\x01\0"
    if kind == "ones":
        return b"\xff" * 80 + b"\0"
    stranger = frame.Encoder()
    stranger.session = frame.Session()
    stranger.session.begin(chance.randrange(1, 65536), 1, chance.randbytes(4), 0, 0)
    values = (
        codes.FORWARD,
        codes.CONTINUOUS,
        chance.randrange(1, 256),
        codes.DRIVER,
        300,
        0,
        0,
        1000,
        0,
    )
    messages.COMMAND.pack(stranger.body, values)
    n = stranger.finish(messages.COMMAND, chance.randrange(65536))
    wire = bytes(stranger.wire[:n])
    return wire[: n // 2] + b"\0" if kind == "half_frames" else wire


def test_maintenance_gives_the_repl_and_a_reset_the_firmware(board: LiveBoard) -> None:
    board.connect()
    board.host.talking = False
    board.host.send(messages.MAINTENANCE, (messages.MAINTENANCE_KEY, 0, 0))
    board.until(lambda: board.host.maintenance is not None, "an answer")
    assert board.host.maintenance == {"key": messages.MAINTENANCE_KEY, "accepted": 1, "reason": 0}
    board.until(lambda: board.host.recent_bytes.endswith(b">>> "), "a prompt")
    board.host.raw(b"print(6*7)\r")
    board.until(lambda: b"\n42\r\n" in board.host.recent_bytes, "the REPL's answer")
    board.host.raw(b"import machine; machine.reset()\r")
    board.host.talking = True
    board.host.states.clear()
    board.host.close()
    board.connect()
    assert board.host.safety == codes.DISARMED
    neutral_throughout(board)


def test_a_wrong_key_does_not_open_maintenance(board: LiveBoard) -> None:
    board.connect()
    before = board.host.stats.get("rx_bad", 0)
    board.host.send(messages.MAINTENANCE, (messages.MAINTENANCE_KEY ^ 1, 0, 0))
    board.until(lambda: board.host.stats.get("rx_bad", 0) > before, "it counts it")
    board.run_ms(300)
    assert board.host.maintenance is None


def test_with_the_relay_held_open_it_does_not_arm(board: LiveBoard) -> None:
    if isinstance(board, EmulatedLiveBoard):
        board.world.faults.inject("relay_stuck_open")
    board.connect()
    board.ask_to_arm(lambda: board.host.has_fault(codes.RELAY_OPEN), "the fault")
    assert board.host.safety == codes.DISARMED
    assert codes.ARMED not in {state["status"] & 15 for _, state in board.host.states}
    neutral_throughout(board)
