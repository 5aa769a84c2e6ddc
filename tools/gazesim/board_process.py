"""The virtual board as a process: the firmware on MicroPython (or CPython), joined to the cable."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import BinaryIO

import gazeboard
import gazelink
from gazeboard.boards import bank_layout as layout
from gazesetup.family import simulates_a_device
from gazesim.bank import Bank
from gazesim.cable import Cable
from gazesim.cabled_board import CabledBoard

CPYTHON = "cpython"
_HANG = 2  # host flag


class BoardProcess(CabledBoard):
    """`interpreter` is the path of a MicroPython, or "cpython"; its stderr is the log."""

    def __init__(
        self, interpreter: str, bank: Bank, bank_path: Path, folder: Path, cable: Cable
    ) -> None:
        super().__init__(bank, bank_path, folder, cable)
        self._interpreter = interpreter

    def pause(self) -> None:
        """Suspend it at any point; when it resumes, that much time has passed."""
        self._bank.set_u32(layout.HOST_FLAGS_AT, _HANG)
        super().pause()

    def _launch(self, line: socket.socket, log: BinaryIO) -> subprocess.Popen[bytes]:
        self._bank.set_u32(layout.HOST_FLAGS_AT, 0)
        cpython = self._interpreter == CPYTHON
        packages = [str(Path(part.__path__[0]).parent) for part in (gazelink, gazeboard)]
        environment: dict[str, str] = dict(os.environ)
        environment["GAZEBOARD_BANK"] = str(self._bank_path)
        environment["GAZEBOARD_STATE"] = str(self._folder)
        environment["PYTHONPATH" if cpython else "MICROPYPATH"] = os.pathsep.join(packages)
        program = sys.executable if cpython else self._interpreter
        return subprocess.Popen(
            [program, "-m", "gazeboard.main"],
            stdin=line.fileno(),
            stdout=line.fileno(),
            stderr=log,
            env=environment,
            start_new_session=True,  # Ctrl-C at the terminal is for the simulator
            preexec_fn=simulates_a_device(signal.SIGKILL),
        )
