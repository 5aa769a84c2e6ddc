"""Plug-ins of the benchmark: a mode that misbehaves on command, and inputs that do nothing."""

from __future__ import annotations

import contextlib
import os
import struct
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gazechair.base.child_records import DATA
from gazechair.plugins import NOTHING, Input, Intent, Mode, World, setting, text
from gazechair.plugins.exchange import Value

LOW, HIGH = 300, 600
FLIP = 7  # worlds between two changes of the output
FLOOD_S = 0.0001
ACTS = ("spin", "flood", "future")


@dataclass(frozen=True)
class Folder:
    """The folder through which benchmark and plug-in communicate."""

    folder: str = setting("", text(), "of the benchmark")


class Flips(Mode):
    """Alternates between two outputs, and records when it sensed the trigger."""

    Settings = Folder
    nl = "Proef"
    en = "Trial"

    def __init__(self, settings: Any) -> None:
        super().__init__(settings)
        self._folder = Path(settings.folder)
        (self._folder / "pid").write_text(str(os.getpid()))
        self._requested = 0

    def drive(self, world: World) -> tuple[int, int] | None:
        for act in ACTS:
            if (self._folder / act).exists():
                (self._folder / act).replace(self._folder / f"{act}.done")
                (self._folder / "began").write_text(str(time.monotonic()))
                _misbehave(act)
        self._requested += 1
        if self._requested % FLIP == 0:
            with open(self._folder / "flips", "a") as notes:
                notes.write(f"{world.born_s}\n")
        return (HIGH if self._requested // FLIP % 2 else LOW), 0


class Quiet(Input):
    """An input without intent."""

    nl = "Stil"
    en = "Quiet"
    rate_hz = 10.0

    def sense(self, now_s: float) -> Intent:
        return NOTHING


class Bad(Quiet):
    """Floods, or loops without end, whenever it runs."""

    Settings = Folder

    def sense(self, now_s: float) -> Intent:
        for act in ACTS:
            if (Path(self.settings.folder) / f"bad {act}").exists():
                _misbehave(act)
        return NOTHING


def _misbehave(act: str) -> None:
    if act == "spin":
        while True:
            pass
    if act == "future":
        monotonic = time.monotonic
        time.monotonic = lambda: monotonic() + 1.0
        return
    while True:  # 10,000 a second, on every pipe there is
        payload = Value(time.monotonic(), 1, NOTHING).pack()
        for fd in range(3, 20):
            with contextlib.suppress(OSError):
                os.write(fd, struct.pack("<I", len(payload) + 1) + DATA + payload)
        time.sleep(FLOOD_S)
