"""`gazechair flash` against the emulated Teensy: new, running, armed, unplugged half-way, wrong."""

import os
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from gazeboard.boards import bank_layout as layout
from gazechair.service.flash import Flasher, FlashError, command, repl, tree
from gazechair.service.flash.repl import Repl
from gazelink import codes, messages
from gazesim.pty_port import PtyPort
from liveboard import NEUTRAL, NOBODY_S, EmulatedLiveBoard, Flashed
from livehost import STOP

# By one process, which flashes its first board once for all of them.
pytestmark = [pytest.mark.m7, pytest.mark.recorded, pytest.mark.xdist_group("board")]


@pytest.fixture(autouse=True)
def one_source(firmware_sources: tree.Sources, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every run flashes what the session's first one did, also while someone edits it."""
    monkeypatch.setattr(tree, "find_sources", lambda: firmware_sources)


class Run:
    """One `gazechair flash`, time passing meanwhile; its lines."""

    def __init__(self, board: EmulatedLiveBoard, connect: type[Repl] = Repl) -> None:
        self.lines: list[str] = []
        self._board = board
        self._connect = connect

    def flash(self, dry_run: bool = False, force: bool = False) -> str:
        self._board.start_background()
        try:
            flasher = Flasher(self.lines.append, self._connect)
            flasher.flash(str(self._board.host.path), dry_run, force)
        finally:
            self._board.stop_background()
        return "\n".join(self.lines)


class ReadOnlyRepl(Repl):
    """Changes nothing on the board. (The board itself writes a small file at each start.)"""

    def write(self, path: str, content: bytes) -> None:
        raise AssertionError(f"write {path}")

    def rename(self, path: str, new_path: str) -> None:
        raise AssertionError(f"rename {path}")

    def remove(self, path: str) -> None:
        raise AssertionError(f"remove {path}")

    def make_folder(self, path: str) -> None:
        raise AssertionError(f"make_folder {path}")


@pytest.fixture
def factory_new(m7: Path, tmp_path: Path) -> Iterator[EmulatedLiveBoard]:
    """An emulated Teensy with MicroPython and nothing else."""
    board = EmulatedLiveBoard(m7, tmp_path, None)
    board.start()
    try:
        yield board
    finally:
        board.stop()


def test_a_new_board_gets_the_firmware_and_runs_it(
    flashed: Flashed, emulated: EmulatedLiveBoard
) -> None:
    assert "no gazechair firmware answers; trying MicroPython's REPL" in flashed.printed
    assert "Teensy 4.0" in flashed.printed
    assert "all verified" in flashed.printed
    assert "runs: teensy40 says hello" in flashed.printed
    emulated.connect()
    assert emulated.host.safety == codes.DISARMED


def test_a_running_board_that_has_it_is_left_as_it_is(emulated: EmulatedLiveBoard) -> None:
    emulated.connect()
    assert "already has this firmware" in Run(emulated, ReadOnlyRepl).flash()


def test_a_dry_run_changes_nothing_and_leaves_it_running(emulated: EmulatedLiveBoard) -> None:
    emulated.connect()
    before, boots = emulated.flash, emulated.bank.boot_count
    assert "nothing was changed" in Run(emulated).flash(dry_run=True)
    assert emulated.flash == before
    assert emulated.bank.boot_count == boots
    emulated.connect()


def test_a_running_board_of_another_layout_is_updated(factory_new: EmulatedLiveBoard) -> None:
    board = factory_new
    board.board.kill()
    board.board.install()
    board.board.start()
    board.connect()
    printed = Run(board).flash()
    assert "left for maintenance" in printed
    assert "changed over" in printed
    assert "runs: teensy40" in printed


def test_an_older_incompatible_firmware_is_updated(emulated: EmulatedLiveBoard) -> None:
    """Its table of messages differs, so only the frozen messages are understood."""
    emulated.board.kill()
    emulated.board.run_instead(OLD_VERSION)
    emulated.board.start()
    emulated.until(lambda: emulated.host.hellos, "its hello")
    assert not emulated.host.in_session
    printed = Run(emulated).flash(force=True)
    assert "firmware 0.0.7" in printed
    assert "left for maintenance" in printed
    assert "runs: teensy40" in printed


OLD_VERSION = b"""
text = open('/flash/main.py').read()
at = text.index('from gazeboard')
exec(text[:at])
import gazelink
from gazelink import frame
gazelink.VERSION = (0, 0, 7)
frame.schema_hash = lambda: 12345
exec(text[at:])
"""


def test_an_armed_board_is_refused_and_stays_armed(emulated: EmulatedLiveBoard) -> None:
    emulated.connect()
    emulated.arm()
    encoder = emulated.host.encoder
    fd = os.open(emulated.host.path, os.O_WRONLY | os.O_NOCTTY)
    ending = threading.Event()
    behind_ms = emulated.bank.tick_ms - emulated.host.ticks

    def stay_armed() -> None:  # what the host goes on saying, from a second opening of the port
        while not ending.wait(0.02):
            messages.COMMAND.pack(encoder.body, STOP)
            n = encoder.finish(messages.COMMAND, (emulated.bank.tick_ms - behind_ms) & 0xFFFF)
            os.write(fd, encoder.wire[:n])

    thread = threading.Thread(target=stay_armed, name="other host")
    thread.start()
    before = emulated.flash
    try:
        with pytest.raises(FlashError, match="is armed; disarm it first"):
            Run(emulated).flash()
    finally:
        ending.set()
        thread.join(10.0)
        os.close(fd)
    assert emulated.flash == before


class PowerCut(FlashError):
    """The board died in the middle."""


# Before the first and after the last nothing else can happen than between them: when named.
@pytest.mark.parametrize(
    "moment",
    [
        pytest.param("write 1", marks=pytest.mark.long),
        pytest.param("write 28", marks=pytest.mark.long),
        "main half written",
        pytest.param("rename 1", marks=pytest.mark.long),
        pytest.param("before reset", marks=pytest.mark.long),
    ],
)
def test_power_cut_half_way_leaves_a_board_that_boots(
    factory_new: EmulatedLiveBoard, moment: str
) -> None:
    board = factory_new
    board.board.kill()
    board.board.install()
    board.board.start()
    board.connect()

    class Dying(Repl):
        writes = renames = 0

        def write(self, path: str, content: bytes) -> None:
            Dying.writes += 1
            if path.endswith("main.py.new") and moment == "main half written":
                super().write(path, content[: len(content) // 2])
                self.die()
            super().write(path, content)
            if moment == f"write {Dying.writes}":
                self.die()

        def rename(self, path: str, new_path: str) -> None:
            Dying.renames += 1
            super().rename(path, new_path)
            if moment == f"rename {Dying.renames}":
                self.die()

        def reset(self) -> None:
            if moment == "before reset":
                self.die()
            super().reset()

        def die(self) -> None:
            board.cut_power()
            raise PowerCut("the board died")

    with pytest.raises(PowerCut):
        Run(board, Dying).flash()
    board.host.close()
    board.host.hellos.clear()
    board.host.states.clear()
    board.board.power_cycle()
    board.connect()
    assert board.host.safety == codes.DISARMED
    assert "runs: teensy40" in Run(board).flash(), "and flashing again ends well"


def test_the_cable_pulled_half_way_is_one_plain_line(
    emulated: EmulatedLiveBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    emulated.connect()

    class Pulled(Repl):
        def write(self, path: str, content: bytes) -> None:
            emulated.board.pull_cable()
            super().write(path, content)

    with pytest.raises(FlashError, match=r"could not write /flash/.* check its cable and repeat"):
        Run(emulated, Pulled).flash(force=True)
    emulated.board.plug_cable()
    monkeypatch.setattr(command, "_HELLO_S", NOBODY_S)
    assert "runs: teensy40" in Run(emulated).flash(), "from the REPL where it was left"


@pytest.mark.parametrize(
    "broken",
    ["raise ValueError('broken')", pytest.param("while True: pass", marks=pytest.mark.long)],
)
def test_a_firmware_that_does_not_run_is_taken_back(
    emulated: EmulatedLiveBoard, broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    emulated.connect()
    before = emulated.host.hellos[-1]
    sources = tree.find_sources()
    app = tmp_path / "app.py"
    app.write_text(broken + "\n")
    changed = tree.Sources({**sources.files, "gazeboard/app.py": app}, sources.main)
    monkeypatch.setattr(tree, "find_sources", lambda: changed)
    monkeypatch.setattr(command, "_START_S", 6.0)
    if broken.startswith("while"):
        with pytest.raises(FlashError, match="does not let us go back"):
            Run(emulated).flash()
        return
    with pytest.raises(FlashError, match="the firmware before is back"):
        Run(emulated).flash()
    emulated.host.hellos.clear()
    emulated.connect()
    assert emulated.host.hellos[-1]["schema_hash"] == before["schema_hash"]


def test_the_button_at_power_on_gives_the_repl(emulated: EmulatedLiveBoard) -> None:
    """For a firmware that hangs: `gazechair flash` then has a board without one."""
    emulated.connect()
    emulated.world.faults.inject("reset_button")
    resets = emulated.bank.u32(layout.SOFT_RESETS_AT)
    emulated.board.power_cycle()
    emulated.host.talking = False
    emulated.host.close()
    emulated.until(lambda: emulated.bank.tick_ms > 500, "half a second")
    assert emulated.bank.u32(layout.SOFT_RESETS_AT) == resets
    emulated.world.faults.clear("reset_button")
    emulated.host.raw(b"\rprint(6*7)\r")
    emulated.until(lambda: b"\n42\r\n" in emulated.host.recent_bytes, "the REPL's answer")
    assert emulated.bank.u32(layout.SOFT_RESETS_AT) == resets
    assert emulated.real_wipers == NEUTRAL


def test_a_port_with_nobody_behind_it_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command, "_HELLO_S", NOBODY_S)
    monkeypatch.setattr(repl, "_TRY_S", int(NOBODY_S))
    silent = PtyPort(tmp_path / "port")
    silent.plug()
    try:
        with pytest.raises(FlashError, match="could not enter the REPL"):
            Flasher(lambda line: None).flash(str(silent.path), False, False)
    finally:
        silent.unplug()
