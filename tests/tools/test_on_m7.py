"""The tests that fit the emulated board, run there; the whole firmware there is tests/board."""

import re
from pathlib import Path

import pytest

from gazemeasure import emulation
from gazesim.board_files import LIB, firmware_files

pytestmark = pytest.mark.m7

TESTS = Path(__file__).resolve().parent.parent
# Those of the firmware stand on the virtual board, which needs a PC.
FILES = sorted([*TESTS.glob("protocol/board_*.py"), *TESTS.glob("tools/board_*.py")])
LIMIT_S = 120.0  # of wall time, for a machine that stalls


@pytest.mark.usefixtures("m7")
@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_passes_on_the_emulated_board(file: Path) -> None:
    """The same files as on CPython, on a Cortex-M7 with the board's own heap and viper code."""
    files = {
        path: text for path, text in firmware_files().items() if path.startswith(f"{LIB}/gazelink/")
    }
    for each in (TESTS / "boardtest.py", *file.parent.glob("*_vectors.py"), file):
        files[f"{LIB}/{each.name}"] = each.read_text()
    run = f"import boardtest\nboardtest.main('{LIB}/{file.name}')\n"
    printed = emulation.run(run, files, LIMIT_S).decode()
    assert re.search(r"^[1-9]\d* passed, 0 failed", printed, re.MULTILINE), printed
