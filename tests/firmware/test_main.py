"""main.py on a board that was reset by its watchdog three times in a row."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from gazeboard.io import bootlog
from gazelink import codes
from gazesim.board_rig import Rig

_MAIN = Path(__file__).resolve().parents[2] / "firmware" / "gazeboard" / "main.py"


@pytest.mark.parametrize(
    ("ended", "runs"), [(bootlog.OPENED, False), (True, False), (bootlog.CLEARED, True)]
)
def test_three_resets_need_clearing(
    ended: int, runs: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It goes on only when somebody cleared the fault; the count starts anew then."""
    rig = Rig()
    rig.board.reset_cause = 3
    for _ in range(2):
        bootlog.watchdog_boots(rig.board)
    said: list[int] = []
    ran: list[Any] = []
    opened: list[bool] = []

    def last_words(_board: Any, reason: int, _detail: str) -> int:
        said.append(reason)
        return ended

    monkeypatch.setattr("gazeboard.boards.virtual.from_environment", lambda: rig.board)
    monkeypatch.setattr("gazeboard.io.bootlog.last_words", last_words)
    rig.board.run = ran.append
    rig.board.open_repl = lambda: opened.append(True)
    runpy.run_path(str(_MAIN))
    assert said == [codes.FAULT_REASON + codes.WATCHDOG_BOOTS]
    assert bool(ran) == runs
    assert bool(opened) != runs
    assert ("watchdog_boots" in rig.files.texts) != runs


def test_the_button_at_power_on_gives_the_repl_before_any_firmware(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """An exception that MicroPython prints; SystemExit would be a soft reset, for ever."""
    machine, micropython = mock.MagicMock(), mock.MagicMock()
    machine.Pin.return_value.value.return_value = 0
    monkeypatch.setitem(sys.modules, "machine", machine)
    monkeypatch.setitem(sys.modules, "micropython", micropython)
    monkeypatch.setitem(sys.modules, "gazeboard.app", None)  # to import it would fail
    with pytest.raises(RuntimeError, match="button pressed at power-on"):
        runpy.run_path(str(_MAIN))
    writes = [call.args for call in machine.I2C.return_value.writeto.call_args_list]
    assert writes == [(0x2C, b"\x00\xaa"), (0x2C, b"\x80\xaa")]  # neutral first (P1)
    micropython.kbd_intr.assert_not_called()


@pytest.mark.parametrize("text", ["", "9", "spoilt\n12345678\n"])
def test_a_damaged_count_starts_anew_with_a_fault(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody is locked out by it, and somebody hears of it."""
    rig = Rig()
    rig.files.texts["watchdog_boots"] = text
    ran: list[Any] = []
    monkeypatch.setattr("gazeboard.boards.virtual.from_environment", lambda: rig.board)
    rig.board.run = ran.append
    runpy.run_path(str(_MAIN))
    assert ran[0].safety.faults >> codes.STORAGE & 1
