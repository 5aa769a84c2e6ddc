"""Runs the demo's daemon as systemd does by our unit file: Type=notify, watchdog, restart."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import gazedeb
from gazedemo.stack import Stack

_UNIT = Path(gazedeb.__file__).parent / "files" / "gazechair.service"
_LOOK_S = 0.02
_ABORTED_S = 10.0  # TimeoutStopSec: then it is killed


def setting_s(name: str) -> float:
    """A time of our unit file, in seconds. Raises KeyError."""
    found = re.search(rf"^{name}=(\d*\.?\d+)(ms|s)?$", _UNIT.read_text(), re.MULTILINE)
    if found is None:
        raise KeyError(name)
    return float(found[1]) / (1000 if found[2] == "ms" else 1)


class Service:
    """`environment` is the daemon's, from its first start on."""

    def __init__(self, folder: Path, restart_s: float | None = None) -> None:
        """`folder`: of the notify socket; `restart_s` None: as in the unit file."""
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(str(folder / "notify"))
        self._socket.setblocking(False)
        self._restart_s = setting_s("RestartSec") if restart_s is None else restart_s
        self._watchdog_s = setting_s("WatchdogSec")
        self.environment = {
            "NOTIFY_SOCKET": str(folder / "notify"),
            "WATCHDOG_USEC": str(round(1e6 * self._watchdog_s)),
        }
        self._stack: Stack | None = None
        self._notified_s = 0.0
        self.restarts = 0
        self.aborted = 0
        """How often the watchdog has ended the daemon."""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="service", daemon=True)

    @contextlib.contextmanager
    def of(self, stack: Stack) -> Iterator[None]:
        """Supervise the running daemon of `stack`; use inside the stack's own context."""
        self._stack = stack
        self._notified_s = time.monotonic()
        self._thread.start()
        try:
            yield
        finally:
            self._stopping.set()
            self._thread.join(10.0)
            self._socket.close()

    def _run(self) -> None:
        assert self._stack is not None
        while not self._stopping.wait(_LOOK_S):
            with contextlib.suppress(BlockingIOError):
                while self._socket.recv(4096):
                    self._notified_s = time.monotonic()
            if self._stack.ended("host") is not None:
                self._again()
            elif time.monotonic() - self._notified_s > self._watchdog_s:
                self._abort()

    def _again(self) -> None:
        assert self._stack is not None
        if self._stopping.wait(self._restart_s):
            return
        self.restarts += 1
        self._stack.start_host()
        # Type=notify: the watchdog begins with READY=1.
        self._notified_s = time.monotonic() + 60.0

    def _abort(self) -> None:
        # systemd sends SIGCONT with it, so that a stopped process ends, too.
        assert self._stack is not None
        self.aborted += 1
        pid = self._stack.pid("host")
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGABRT)
            os.kill(pid, signal.SIGCONT)
        end_s = time.monotonic() + _ABORTED_S
        while self._stack.ended("host") is None and not self._stopping.wait(_LOOK_S):
            if time.monotonic() > end_s:
                os.kill(pid, signal.SIGKILL)
