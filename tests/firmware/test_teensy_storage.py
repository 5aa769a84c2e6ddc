"""A store that fails leaves the Teensy's watchdog as strict as it was.

The Teensy's own file of the firmware, over stand-ins for `machine` and `micropython`.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from gazeboard.io.storage import Files


class Watchdog:
    """Notes its time-out."""

    def __init__(self) -> None:
        self.now_ms = 500
        self.seen: list[int] = []

    def feed(self) -> None:
        """Nothing bites here."""

    def timeout_ms(self, timeout_ms: int) -> None:
        """A new time-out, in force at once."""
        self.now_ms = timeout_ms
        self.seen.append(timeout_ms)


@pytest.fixture
def teensy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    """A Teensy40 whose flash is a folder and whose pins are none."""
    stand_in: Any = ModuleType("micropython")
    stand_in.alloc_emergency_exception_buf = lambda size: None
    monkeypatch.setitem(sys.modules, "micropython", stand_in)
    monkeypatch.setitem(sys.modules, "machine", ModuleType("machine"))
    monkeypatch.delitem(sys.modules, "gazeboard.boards.teensy40", raising=False)
    module = importlib.import_module("gazeboard.boards.teensy40")
    board = module.Teensy40.__new__(module.Teensy40)
    board._files = Files(str(tmp_path))
    board._watchdog = Watchdog()
    monkeypatch.delitem(sys.modules, "gazeboard.boards.teensy40")
    return board


def test_the_watchdog_is_patient_only_while_the_flash_is_written(teensy: Any) -> None:
    """8 s for the erase, 500 ms after it."""
    teensy.store("settings.json", "text")
    assert teensy.load("settings.json") == "text"
    assert teensy._watchdog.seen == [8000, 500]
    teensy.remove("settings.json")
    assert teensy.load("settings.json") is None
    assert teensy._watchdog.seen == [8000, 500] * 2


@pytest.mark.parametrize("error", [OSError(28), MemoryError(), ValueError("spoilt")])
@pytest.mark.parametrize("call", ["store", "remove"])
def test_a_flash_that_refuses_leaves_it_strict(
    teensy: Any, call: str, error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whatever was raised, the board that hangs next is reset within 500 ms."""

    def refuse(*_: str) -> None:
        raise error

    monkeypatch.setattr(teensy._files, call, refuse)
    arguments = ("settings.json", "text") if call == "store" else ("settings.json",)
    with pytest.raises(type(error)):
        getattr(teensy, call)(*arguments)
    assert teensy._watchdog.now_ms == 500
