"""The emulated board: the tests that fit it, and the firmware as it is flashed, from reset on."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from gazelink import codes
from m7rig import NEUTRAL, EmulatedChair, board_files, execute, script

pytestmark = pytest.mark.m7

TESTS = Path(__file__).resolve().parent.parent
# Those of the firmware stand on the virtual board, which needs a PC.
FILES = sorted([*TESTS.glob("protocol/board_*.py"), *TESTS.glob("tools/board_*.py")])
RUN = "sys.path.append('/flash')\nimport boardtest\nif boardtest.main({!r}): raise SystemExit(1)"


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_passes_on_the_emulated_board(file: Path, m7: Path, tmp_path: Path) -> None:
    """The same files as on CPython, on a Cortex-M7 with the board's own heap and viper code."""
    files = {name: text for name, text in board_files().items() if name.startswith("gazelink")}
    helpers = list(file.parent.glob("*_vectors.py"))
    for each in (TESTS / "boardtest.py", *helpers, file):
        files[each.name] = each.read_text()
    printed = execute(m7, script(files, RUN.format(f"/flash/{file.name}")), tmp_path)
    assert re.search(r"^[1-9]\d* passed, 0 failed", printed, re.MULTILINE), printed


@pytest.fixture
def chair(m7: Path, tmp_path: Path) -> Iterator[EmulatedChair]:
    """The firmware just started on the emulated board."""
    emulated = EmulatedChair(m7, tmp_path)
    emulated.start()
    try:
        yield emulated
    finally:
        emulated.stop()


def test_the_firmware_drives_and_falls_back_to_neutral(chair: EmulatedChair) -> None:
    """Reset, handshake, arming, forward, host gone, host back: as it would go on the Teensy."""
    chair.until(lambda: bool(chair.hello), "the board's HELLO")
    chair.talking = True
    chair.until(lambda: chair.states_heard > 0, "a session with state frames")
    assert chair.hello["role"] == 1
    assert chair.hello["flags"] & 1, "an emulated board must say that it is simulated"
    assert chair.wipers == NEUTRAL
    assert chair.safety_state == codes.DISARMED

    chair.arm()
    assert chair.world.relay.closed
    assert chair.wipers == NEUTRAL

    start_x_m, _, _ = chair.world.pose

    def moved() -> bool:
        return abs(chair.world.pose[0] - start_x_m) > 0.05

    chair.drive(codes.FORWARD, moved, "the chair moving")

    chair.talking = False
    chair.until(lambda: chair.wipers == NEUTRAL, "neutral with the host silent")
    chair.until(lambda: chair.safety_state == codes.DISARMED, "disarmed with the host silent")

    # Forward is still held, yet nothing moves: that takes arming and a new press.
    chair.order = None
    chair.talking = True
    heard = chair.states_heard
    chair.until(lambda: chair.states_heard > heard + 50, "state frames after the host is back")
    assert chair.wipers == NEUTRAL
    assert chair.safety_state == codes.DISARMED


def test_a_host_that_talks_while_the_board_boots_does_not_stop_it(chair: EmulatedChair) -> None:
    """Frames hold byte 3, and a HELLO with stamp 0 begins with it."""
    chair.talking = True
    chair.until(lambda: chair.states_heard > 0, "a session with state frames")
