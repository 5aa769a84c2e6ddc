"""Every board_*.py once more, under MicroPython: one process a file."""

import os
from pathlib import Path

import pytest

import gazesetup
from onmicropython import TESTS, assert_passes

FILES = sorted(TESTS.glob("*/board_*.py"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_passes_on_micropython(file: Path, micropython: gazesetup.MicroPython) -> None:
    """All tests of the file pass there too."""
    assert_passes(file, micropython, None)


def test_there_are_such_files() -> None:
    """An empty search would pass without testing anything."""
    assert FILES
    assert os.access(TESTS / "boardtest.py", os.R_OK)
