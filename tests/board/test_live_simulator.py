"""The simulator with the emulated Teensy as its board: one port, one control socket, as ever."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from gazelink import codes
from liveboard import LiveBoard

pytestmark = [pytest.mark.m7, pytest.mark.recorded, pytest.mark.xdist_group("board")]


def test_runs_the_emulated_board_behind_its_cable(m7: Path, tmp_path: Path) -> None:
    words = [sys.executable, "-m", "gazesim", "--dir", str(tmp_path), "--board", f"m7:{m7}"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    simulator = subprocess.Popen(words, stdout=subprocess.PIPE, text=True, env=environment)
    try:
        assert simulator.stdout is not None
        ready = json.loads(simulator.stdout.readline())
        board = LiveBoard(Path(ready["board"]), simulated=True)
        board.connect()
        assert board.host.hellos[-1]["name"].rstrip(b"\0") == b"teensy40"
        board.ask_to_arm(lambda: board.host.safety == codes.ARMED, "armed")
        board.stop()
    finally:
        simulator.terminate()
        assert simulator.wait(20.0) == 0


def test_a_folder_without_an_emulation_is_refused(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "gazesim", "--dir", str(tmp_path), "--board", f"m7:{tmp_path}"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    ended = subprocess.run(words, capture_output=True, text=True, env=environment, timeout=60)
    assert ended.returncode == 2
    assert "no emulated board" in ended.stderr
