"""Every board_*.py on MicroPython's WebAssembly build: a newer release, the plain form of viper.

That form has no machine words: what a viper function computes must fit 31 bits without them, and be
the same. What it allocates is no matter there (tests/boardtest.py). `tools/test` runs a few of
them, `tools/prove` runs and records all but those of the whole firmware and the longest of the
core, which take minutes there: `tools/test tests/tools/test_on_wasm.py` runs these too.
"""

import subprocess
from pathlib import Path

import pytest

import gazesetup
from gazesetup.paths import SOURCE_ROOTS
from onmicropython import LIMIT_S, TESTS

LONG = ("board_core_board", "board_core_directions", "board_core_owner")
ALWAYS = ("board_core_press", "board_core_motion", "board_wire")


def marks(file: Path) -> list[pytest.MarkDecorator]:
    if file.stem in LONG or "board_rig" in file.read_text():
        return [pytest.mark.long]
    return [] if file.stem in ALWAYS else [pytest.mark.recorded]


FILES = [pytest.param(file, marks=marks(file)) for file in sorted(TESTS.glob("*/board_*.py"))]
ROOTS = [gazesetup.ROOT / name for name in SOURCE_ROOTS if name != "host"]


@pytest.fixture(scope="session")
def wasm() -> Path:
    try:
        return gazesetup.ensure_wasm()
    except gazesetup.NotAvailable as error:
        pytest.skip(str(error))


@pytest.mark.parametrize("file", FILES, ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_passes_on_webassembly(file: Path, wasm: Path) -> None:
    words = ["node", TESTS / "onwasm.mjs", wasm, file.relative_to(TESTS), *ROOTS, TESTS]
    result = subprocess.run(
        [str(word) for word in words], capture_output=True, text=True, timeout=LIMIT_S
    )
    assert result.returncode == 0, result.stdout[-4000:] + result.stderr[-1000:]
    assert "0 failed" in result.stdout, result.stdout[-4000:]
