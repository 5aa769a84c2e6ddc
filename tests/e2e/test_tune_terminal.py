"""`gazechair tune` in a real terminal, on a simulated chair with one front lidar, in real time."""

from __future__ import annotations

import json
import os
import pty
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import gazesetup
from gazedemo.stack import CHAIR_CONFIG

pytestmark = pytest.mark.e2e

LIMIT_S = 120.0


@pytest.fixture
def config(tmp_path: Path) -> Iterator[Path]:
    """A chair in the open, and the configuration of a host beside it."""
    words = [sys.executable, "-m", "gazesim", "--dir", str(tmp_path), "--room", "open"]
    simulator = subprocess.Popen(
        words, env=gazesetup.source_environment(), stdout=subprocess.PIPE, text=True
    )
    try:
        assert simulator.stdout is not None
        ready = json.loads(simulator.stdout.readline())
        path = tmp_path / "gazechair.toml"
        path.write_text(CHAIR_CONFIG.format(**ready))
        yield path
    finally:
        simulator.terminate()
        simulator.wait(LIMIT_S)


class Terminal:
    """`gazechair tune` with somebody at the keyboard."""

    def __init__(self, config: Path) -> None:
        words = ["-m", "gazechair", "tune", "--profile", "3.1", "--config", str(config)]
        self.text = ""
        self._pid, self._keys = pty.fork()
        if self._pid == 0:
            os.execve(sys.executable, [sys.executable, *words], gazesetup.source_environment())

    def until(self, words: str) -> None:
        """Wait until it says that."""
        end_s = time.monotonic() + LIMIT_S
        while words not in self.text:
            assert time.monotonic() < end_s, self.text
            assert self._read(), self.text

    def press(self, key: bytes) -> None:
        """Press a key."""
        os.write(self._keys, key)

    def exit_code(self) -> int:
        """Wait for its end."""
        while self._read():
            pass
        os.close(self._keys)
        return os.waitstatus_to_exitcode(os.waitpid(self._pid, 0)[1])

    def _read(self) -> bool:
        if not select.select([self._keys], [], [], LIMIT_S)[0]:
            return False
        try:
            found = os.read(self._keys, 4096)
        except OSError:  # how a pty says that nobody is there any more
            return False
        self.text += found.decode()
        return bool(found)


# 50 s in real time; in virtual time: tests/host/commissioning/tune, tests/e2e/test_first_drive.py.
@pytest.mark.long
def test_a_chair_with_one_lidar_is_tuned_and_what_was_found_is_stored(config: Path) -> None:
    terminal = Terminal(config)
    terminal.until("Enter: go")
    terminal.press(b"\n")
    assert terminal.exit_code() == 0, terminal.text
    assert terminal.text.count("%, ") == 10, "pulses"
    assert "stored; the board now drives with profile 3.1" in terminal.text


def test_any_key_stops_it_and_nothing_is_changed(config: Path) -> None:
    for _ in range(5):
        terminal = Terminal(config)
        terminal.until("Enter: go")
        terminal.press(b"\n")
        terminal.until("left, ")
        terminal.press(b"x")
        code = terminal.exit_code()
        # A machine that stalls during a pulse has the board stop it first.
        if "host_silent" not in terminal.text:
            break
    assert code == 2
    assert "stopped; nothing was changed" in terminal.text
