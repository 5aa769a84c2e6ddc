"""Every board_*.py once more, under MicroPython: one process a file."""

import os
import subprocess
from pathlib import Path

import pytest

import gazesetup

TESTS = Path(__file__).resolve().parent.parent
FILES = sorted(TESTS.glob("*/board_*.py"))
LIMIT_S = 300


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_passes_on_micropython(file: Path, micropython: gazesetup.MicroPython) -> None:
    """All tests of the file pass there too."""
    env = gazesetup.source_environment()
    env["MICROPYPATH"] += f":{TESTS}"
    result = subprocess.run(
        [str(micropython.path), "-X", "heapsize=4m", str(TESTS / "boardtest.py"), str(file)],
        env=env,
        cwd=TESTS.parent,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert result.returncode == 0, f"{micropython.description}\n{result.stdout}{result.stderr}"
    assert "0 failed" in result.stdout


def test_there_are_such_files() -> None:
    """An empty search would pass without testing anything."""
    assert FILES
    assert os.access(TESTS / "boardtest.py", os.R_OK)
