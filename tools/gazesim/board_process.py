"""The virtual board as a process: the firmware on MicroPython (or CPython), joined to the cable."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path

from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.cable import Cable

CPYTHON = "cpython"
_ROOT = Path(__file__).resolve().parents[2]
_PR_SET_PDEATHSIG = 1
_CAUSE_RESET = 5
_SEND_BUFFER = 4608  # small, so that a board that does not read holds up the host soon
_libc = ctypes.CDLL(None, use_errno=True)


def _die_with_parent() -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


class BoardProcess:
    """Starts and ends the firmware's process; it dies with the thread that called `start`.

    `interpreter` is the path of a MicroPython, or "cpython". The board's files live in `folder`,
    what it prints on stderr goes to `folder`/board.log. A process that ends by itself was a reset:
    `poll` starts it again. Its port vanishes meanwhile, as a Teensy's does.
    """

    def __init__(
        self, interpreter: str, bank: Bank, bank_path: Path, folder: Path, cable: Cable
    ) -> None:
        self._interpreter = interpreter
        self._bank = bank
        self._bank_path = bank_path.resolve()
        self._folder = folder.resolve()
        self._cable = cable
        self._cable_in = True
        self._process: subprocess.Popen[bytes] | None = None
        self._line: socket.socket | None = None
        self._paused = False
        self.resets = 0  # times it ended by itself

    @property
    def running(self) -> bool:
        """Whether the process is there (paused or not)."""
        return self._process is not None and self._process.poll() is None

    def start(self) -> None:
        """Start the firmware; OSError when the interpreter can't be run."""
        self._folder.mkdir(parents=True, exist_ok=True)
        cpython = self._interpreter == CPYTHON
        sources = os.pathsep.join(str(_ROOT / part) for part in ("protocol", "firmware"))
        environment: dict[str, str] = dict(os.environ)
        environment["GAZEBOARD_BANK"] = str(self._bank_path)
        environment["GAZEBOARD_STATE"] = str(self._folder)
        environment["PYTHONPATH" if cpython else "MICROPYPATH"] = sources
        program = sys.executable if cpython else self._interpreter
        ours, boards = socket.socketpair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        try:
            with boards, open(self._folder / "board.log", "ab") as log:
                self._process = subprocess.Popen(
                    [program, str(_ROOT / "firmware" / "main.py")],
                    stdin=boards.fileno(),
                    stdout=boards.fileno(),
                    stderr=log,
                    env=environment,
                    start_new_session=True,  # Ctrl-C at the terminal is for the simulator
                    preexec_fn=_die_with_parent,
                )
        except OSError:
            ours.close()
            raise
        self._line = ours
        self._paused = False
        self._cable.connect_board(ours.fileno())
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
        """Let it go on after `pause`."""
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
            self._cable.plug()

    def poll(self) -> None:
        """Start it again when it ended by itself (a reset)."""
        if self._process is not None and self._process.poll() is not None:
            self.resets += 1
            self.kill()
            self.start()
