"""`tools/demo` takes all it started with it, however and whenever it is ended."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest

import gazesetup

# Odometry is not ready in the time that the demo gives it beside pages and emulated boards.
pytestmark = pytest.mark.e2e

LIMIT_S = 60.0
RUNNING = "The driver's page:"
BOARD_STARTS = "* simulator and firmware"
HOST_STARTS = "* host and driver's page"
CASES = [
    (signal.SIGTERM, RUNNING),
    (signal.SIGKILL, RUNNING),
    (signal.SIGINT, BOARD_STARTS),
    (signal.SIGHUP, HOST_STARTS),
    (signal.SIGKILL, HOST_STARTS),
]


class Family:
    """A demo and every process that came of it, known by a mark in its environment."""

    def __init__(self, folder: Path) -> None:
        self._mark = f"GAZEDEMO_FAMILY={uuid.uuid4()}".encode()
        name, value = self._mark.decode().split("=")
        environment = {**os.environ, name: value, "TMPDIR": str(folder)}
        for variable in ("DISPLAY", "WAYLAND_DISPLAY"):
            environment.pop(variable, None)  # it would open a browser
        self.demo = subprocess.Popen(
            [sys.executable, str(gazesetup.ROOT / "tools" / "demo"), "--port", "0"],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )

    def until(self, words: str) -> None:
        """Wait until the demo prints that."""
        assert self.demo.stdout is not None
        seen = []
        for line in self.demo.stdout:
            seen.append(line)
            if words in line:
                return
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


@pytest.fixture
def family(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Family]:
    family = Family(tmp_path_factory.mktemp("d"))
    yield family
    family.end()


@pytest.mark.parametrize(
    ("number", "moment"), CASES, ids=lambda value: getattr(value, "name", None)
)
def test_a_demo_that_is_ended_leaves_nothing_running(
    family: Family, number: signal.Signals, moment: str
) -> None:
    family.until(moment)
    if moment == RUNNING:
        assert len(family.alive()) >= 4  # demo, simulator, board, host
    family.demo.send_signal(number)
    end_s = time.monotonic() + LIMIT_S
    while family.alive() and time.monotonic() < end_s:
        time.sleep(0.02)
    assert family.alive() == []
    assert family.demo.wait(LIMIT_S) == (-signal.SIGKILL if number == signal.SIGKILL else 0)
