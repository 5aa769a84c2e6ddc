"""The board's settings from the command line, with the real firmware on a pseudo terminal."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import gazesetup
from gazechair import cli
from gazechair.service import board_connection
from gazelink.settings_table import NAMES, TABLE
from gazesim.simulator import Simulator

pytestmark = pytest.mark.e2e


@pytest.fixture
def port(tmp_path: Path, micropython: gazesetup.MicroPython) -> Iterator[str]:
    """A simulated board's port."""
    stopping = threading.Event()
    started = threading.Event()

    def simulate() -> None:
        rig = Simulator(tmp_path / "sim", str(micropython.path), "open")
        rig.start()
        started.set()
        try:
            while not stopping.is_set():
                rig.run(until_s=time.monotonic() + 0.05)
        finally:
            rig.stop()

    thread = threading.Thread(target=simulate, name="simulator")
    thread.start()
    assert started.wait(20)
    yield str(tmp_path / "sim" / "board")
    stopping.set()
    thread.join(20)


def test_all_are_read_changed_and_saved(port: str, capsys: pytest.CaptureFixture[str]) -> None:
    with board_connection.connected(port) as board:
        assert board.all() == [row[1] for row in TABLE]
    words = ["settings", "--port", port, "--set", "linear_permille", "250", "--save"]
    assert cli.main(words) == 0
    assert "250*" in capsys.readouterr().out
    with board_connection.connected(port) as board:
        assert board.all()[NAMES.index("linear_permille")] == 250
        board.defaults()
        assert board.all() == [row[1] for row in TABLE]
