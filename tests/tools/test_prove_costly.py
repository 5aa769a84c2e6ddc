"""The part of costly tests: what it rests upon, and what comes of one that fails or is skipped."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from gazeprove import part_costly, record
from gazesetup import ROOT
from patience import wait_until

GOOD = "import pytest\n\n@pytest.mark.costly\ndef test_it():\n    assert True\n"


ENDLESS = """import os, pathlib, time, pytest

@pytest.mark.costly
def test_it():
    pathlib.Path("running").write_text(str(os.getpid()))
    while True:
        time.sleep(0.01)
"""
PROVER = """from pathlib import Path
from gazeprove import part_costly
part_costly.ROOT = Path.cwd()
part_costly._TESTS = Path.cwd() / "tests"
part_costly.costly(False, print)
"""


def written(root: Path, name: str, text: str) -> Path:
    file = root / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)
    return file


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small checkout."""
    written(tmp_path, "pyproject.toml", "[tool.pytest.ini_options]\n")
    for name in ("host/gazechair/a.py", "web/strings/en.json", "tests/web/b.py"):
        written(tmp_path, name, "1")
    written(tmp_path, "tests/promises.py", (ROOT / "tests" / "promises.py").read_text())
    monkeypatch.setattr(part_costly, "ROOT", tmp_path)
    monkeypatch.setattr(part_costly, "_TESTS", tmp_path / "tests")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("host/gazechair/a.py", "host/gazechair"),
        ("host/gazechair/new.py", "host/gazechair"),
        ("host/gazechair/driving/new.toml", "host/gazechair/driving"),
        ("web/strings/en.json", "web/strings"),
        ("tests/goingrig.py", "tests"),
        ("pyproject.toml", "pyproject.toml"),
    ],
)
def test_a_changed_or_new_file_is_told_by_its_folder(tree: Path, name: str, folder: str) -> None:
    row = {"proved": True, "of": record.digest_of(part_costly.digests())}
    stored = {"parts": {"costly": row}, "files": {row["of"]: part_costly.digests()}}
    assert record.why_not("costly", stored, part_costly.digests()) == ""
    written(tree, name, "2")
    wanted = f"costly: {Path(folder).name} changed since it was proven: run tools/prove"
    assert record.why_not("costly", stored, part_costly.digests()) == wanted


@pytest.mark.parametrize("name", ["tests/web/b.py", "docs/map.md", "web/driver.js"])
def test_what_no_costly_test_can_see_does_not_count(tree: Path, name: str) -> None:
    before = part_costly.digests()
    written(tree, name, "2")
    assert part_costly.digests() == before


@pytest.mark.parametrize(
    ("text", "tests", "whole"),
    [
        (GOOD, 1, True),
        (GOOD.replace("assert True", "pytest.skip('not here')"), 0, False),
        (GOOD + GOOD.replace("_it", "_other").replace("True", "False"), 1, False),
    ],
    ids=["passes", "is skipped", "one of two fails"],
)
def test_only_tests_that_all_passed_count(tree: Path, text: str, tests: int, whole: bool) -> None:
    written(tree, "tests/test_one.py", text)
    figures, short = part_costly.costly(False, print)
    assert (figures["tests"], not short) == (tests, whole)


def runs(pid: int) -> bool:
    """Whether there is such a process, other than one that has ended and nobody waits for."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def test_the_tests_end_with_a_prover_that_is_killed(tree: Path) -> None:
    written(tree, "tests/test_one.py", ENDLESS)
    running = tree / "running"
    with subprocess.Popen(
        [sys.executable, "-c", PROVER],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))},
    ) as prover:
        wait_until(lambda: running.exists() and running.read_text(), "a test that runs")
        prover.kill()
    wait_until(lambda: not runs(int(running.read_text())), "the end of its process")


def test_no_costly_test_needs_a_clock_a_browser_or_a_board() -> None:
    for file in (ROOT / "tests").rglob("test_*.py"):
        text = file.read_text()
        if "mark.costly" in text and file != Path(__file__):
            assert not re.search(r"mark\.(e2e|m7|browser|last|fuzz)|time\.sleep|given\(", text), (
                file
            )
