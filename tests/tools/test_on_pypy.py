"""Which of the firmware's tests fails in PyPy is said, and what they measure is noted."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import gazesetup

LIMIT_S = 60.0
PASSES = """
from promises import CORE, measured

def test_in_time():
    measured(CORE, "P1", "a cause", 2, 5)
"""
FAILS = """
def test_too_late():
    assert 6 <= 5

def test_another():
    pass
"""


def run(folder: Path, **files: str) -> subprocess.CompletedProcess[str]:
    """Run these files as tools/test does, in this interpreter."""
    for name, text in files.items():
        (folder / f"{name}.py").write_text(text)
    env = gazesetup.source_environment()
    env["PYTHONPATH"] += f"{os.pathsep}{gazesetup.ROOT / 'tests'}"
    env["GAZECHAIR_PROMISES"] = str(folder)
    return subprocess.run(
        [sys.executable, "-m", "onpypy", *(str(folder / f"{name}.py") for name in files)],
        env=env,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )


def test_what_is_measured_is_noted_as_in_pytest(tmp_path: Path) -> None:
    done = run(tmp_path, board_good=PASSES)
    assert done.returncode == 0, done.stdout + done.stderr
    (notes,) = tmp_path.glob("*.json")
    (note,) = json.loads(notes.read_text())
    assert (note["promise"], note["ms"], note["test"]) == ("P1", 2, "test_in_time")


def test_a_test_that_fails_is_said_and_the_others_run(tmp_path: Path) -> None:
    done = run(tmp_path, board_bad=FAILS, board_good=PASSES)
    assert done.returncode == 1
    assert "board_bad.py::test_too_late" in done.stdout
    assert "assert 6 <= 5" in done.stdout
    assert "board_bad.py 2 tests, 1 failed" in done.stdout
    assert list(tmp_path.glob("*.json"))


@pytest.mark.parametrize("text", ["", "import not_there"])
def test_a_file_without_tests_is_no_success(tmp_path: Path, text: str) -> None:
    assert run(tmp_path, board_none=text).returncode != 0
