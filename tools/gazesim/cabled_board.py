"""A board that is its own process, joined to the cable: the part common to all kinds."""

from __future__ import annotations

import contextlib
import signal
import socket
import subprocess
from abc import ABC, abstractmethod
from pathlib import Path
from typing import BinaryIO

from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.cable import Cable

_CAUSE_RESET = 5
_SEND_BUFFER = 4608  # small, so that a board that does not read soon blocks the host


class CabledBoard(ABC):
    """Starts and ends the board's process; it dies with the thread that called `start`.

    The board's files live in `folder`, its log is `folder`/board.log. A process that ends by
    itself was a reset: `poll` starts it again. Its port vanishes meanwhile, as a Teensy's does.
    """

    def __init__(self, bank: Bank, bank_path: Path, folder: Path, cable: Cable) -> None:
        self._bank = bank
        self._bank_path = bank_path.resolve()
        self._folder = folder.resolve()
        self._cable = cable
        self._cable_in = True
        self._process: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None
        self._paused = False
        self.resets = 0  # times it reset itself

    @abstractmethod
    def _launch(self, line: socket.socket, log: BinaryIO) -> subprocess.Popen[bytes]:
        """Start the process with `line` as its serial line; OSError when it can't be run."""

    @property
    def running(self) -> bool:
        """Whether the process is there (paused or not)."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start it; OSError when what runs the board is not there."""
        self._folder.mkdir(parents=True, exist_ok=True)
        ours, boards = socket.socketpair()
        # Not in the other direction: QEMU sends byte by byte, and the kernel charges each ~1 kB.
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        try:
            with boards, open(self._folder / "board.log", "ab") as log:
                self._process = self._launch(boards, log)
        except OSError:
            ours.close()
            raise
        self._line = ours
        self._paused = False
        self._cable.connect_board(ours.fileno())
        self._show_port()

    def _show_port(self) -> None:
        """The board has (re)started: its port shows, if the cable is in."""
        if self._cable_in:
            self._cable.plug()

    def kill(self) -> None:
        """End it at once, as pulling its power does: the port vanishes."""
        self._cable.pull()
        self._cable.connect_board(-1)
        if self._process is not None:
            with contextlib.suppress(ProcessLookupError):
                self._process.kill()
            self._process.wait(timeout=10.0)
            self._process = None
        if self._line is not None:
            self._line.close()
            self._line = None

    stop = kill

    def restart(self) -> None:
        """Reset it: as the board's own reset, the cause is handed over."""
        self.kill()
        self._bank.set_u32(layout.NEXT_CAUSE_AT, _CAUSE_RESET)
        self.start()

    def power_cycle(self) -> None:
        """Take its power away and give it back."""
        self.kill()
        self._bank.power_on()
        self.start()

    def pause(self) -> None:
        """Stop it in the middle of whatever it does, as a hang with interrupts off."""
        if self._process is not None:
            self._process.send_signal(signal.SIGSTOP)
            self._paused = True

    def resume(self) -> None:
        """Let it continue after `pause`."""
        if self._process is not None and self._paused:
            self._process.send_signal(signal.SIGCONT)
            self._paused = False

    def pull_cable(self) -> None:
        """Pull the board's USB plug at the host; the board itself keeps its power."""
        self._cable_in = False
        self._cable.pull()

    def plug_cable(self) -> None:
        """Plug it in again; the port shows as soon as the board runs."""
        self._cable_in = True
        if self.running:
            self._show_port()

    def poll(self) -> None:
        """Start it again when it ended by itself (a reset)."""
        if self._process is not None and self._process.poll() is not None:
            self.resets += 1
            self.kill()
            self.start()
