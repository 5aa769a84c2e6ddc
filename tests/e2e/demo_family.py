"""A demo as a person starts it, and every process that comes of it."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import uuid
from collections.abc import Sequence
from pathlib import Path

import pytest

import gazesetup

LIMIT_S = 60.0
RUNNING = "The driver's page:"
DEMO = (sys.executable, str(gazesetup.ROOT / "tools" / "demo"))


class Family:
    """A demo and every process that came of it, known by a mark in its environment."""

    def __init__(self, folder: Path, command: Sequence[str] = DEMO, **more: str) -> None:
        """`command`: how it is started; `more` of its environment."""
        self._mark = f"GAZEDEMO_FAMILY={uuid.uuid4()}".encode()
        name, value = self._mark.decode().split("=")
        environment = {**os.environ, **more, name: value, "TMPDIR": str(folder)}
        for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
            environment.pop(variable, None)  # it would open a browser
        self.demo = subprocess.Popen(
            [*command, "--port", "0"],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def until(self, words: str) -> str:
        """Wait until the demo prints that; the line."""
        assert self.demo.stdout is not None
        seen = []
        for line in self.demo.stdout:
            seen.append(line)
            if words in line:
                return line
        pytest.fail(f"the demo never said {words!r}: {seen}")

    def alive(self) -> list[int]:
        """Ids of those that still run."""
        found = []
        for entry in Path("/proc").iterdir():
            with contextlib.suppress(OSError, ValueError):
                pid = int(entry.name)
                state = (entry / "stat").read_text().rsplit(")", 1)[1].split()[0]
                if self._mark in (entry / "environ").read_bytes().split(b"\0") and state != "Z":
                    found.append(pid)
        return found

    def end(self) -> None:
        for pid in self.alive():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self.demo.wait(LIMIT_S)
        assert self.demo.stdout is not None
        self.demo.stdout.close()
