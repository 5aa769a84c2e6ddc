"""Every board_*.py once more, under MicroPython: one process a file.

Those of the firmware run there as they are flashed (tests/host/service/test_flash_calls.py);
`tools/test tests/tools/test_on_micropython.py` runs them as they are written, too.
"""

import os
from pathlib import Path

import pytest

import gazesetup
from onmicropython import TESTS, assert_passes

FILES = [
    pytest.param(file, marks=[pytest.mark.long] if file.parent.name == "firmware" else [])
    for file in sorted(TESTS.glob("*/board_*.py"))
]


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_passes_on_micropython(file: Path, micropython: gazesetup.MicroPython) -> None:
    """All tests of the file pass there too."""
    assert_passes(file, micropython, None)


def test_there_are_such_files() -> None:
    """An empty search would pass without testing anything."""
    assert FILES
    assert os.access(TESTS / "boardtest.py", os.R_OK)
