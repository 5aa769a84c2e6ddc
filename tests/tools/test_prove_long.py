"""The parts that run tests: side by side on each core, and what comes of one that fails."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazeprove import part_long

GOOD = "def test_it():\n    assert True\n"
# What is told of it -> a test.
BAD = {
    "planted": "def test_other():\n    assert False, 'planted'\n",
    "1 skipped": "import pytest\ndef test_other():\n    pytest.skip('not here')\n",
    "no board": "import pytest\n@pytest.fixture\ndef board():\n    raise OSError('no board')\n"
    "def test_other(board):\n    assert True\n",
    "crashed": "import os\ndef test_other():\n    os._exit(0)\n",
}
# Each waits for the other.
MEETING = """import pathlib, time, pytest

@pytest.mark.parametrize("me", [0, 1])
def test_it(me):
    here = pathlib.Path(__file__).parent
    (here / f"begun-{me}").touch()
    end_s = time.monotonic() + 60.0
    while not (here / f"begun-{1 - me}").exists():
        assert time.monotonic() < end_s
        time.sleep(0.01)
"""


@pytest.fixture
def tests(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of those on the emulated board."""
    monkeypatch.setattr(part_long, "_EMULATED", tmp_path)
    monkeypatch.setattr(part_long, "ensure_qemu", lambda: "QEMU")
    return tmp_path


@pytest.mark.parametrize("cores", [1, 2])
def test_all_of_them_count(tests: Path, monkeypatch: pytest.MonkeyPatch, cores: int) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: cores)
    (tests / "test_one.py").write_text(GOOD)
    (tests / "test_two.py").write_text(GOOD)
    assert part_long.emulated(False, print) == ({"tests": 2}, [])


def test_on_two_cores_two_run_side_by_side(tests: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    (tests / "test_one.py").write_text(MEETING)
    assert part_long.emulated(False, print) == ({"tests": 2}, [])


@pytest.mark.parametrize("source", BAD)
def test_one_of_two_is_not_enough(tests: Path, source: str) -> None:
    (tests / "test_one.py").write_text(GOOD)
    (tests / "test_two.py").write_text(BAD[source])
    figures, short = part_long.emulated(False, print)
    assert figures["tests"] == 1
    assert source in "\n".join(short)
