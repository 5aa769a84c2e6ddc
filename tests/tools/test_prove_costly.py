"""The part of costly tests: what it rests upon, and what comes of one that fails or is skipped."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from gazeprove import part_costly, record
from gazesetup import ROOT

GOOD = "import pytest\n\n@pytest.mark.costly\ndef test_it():\n    assert True\n"


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
    said = {"parts": {"costly": row}, "files": {row["of"]: part_costly.digests()}}
    assert record.why_not("costly", said, part_costly.digests()) == ""
    written(tree, name, "2")
    wanted = f"costly: {Path(folder).name} changed since it was proven: run tools/prove"
    assert record.why_not("costly", said, part_costly.digests()) == wanted


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


def test_no_costly_test_needs_a_clock_a_browser_or_a_board() -> None:
    for file in (ROOT / "tests").rglob("test_*.py"):
        text = file.read_text()
        if "mark.costly" in text and file != Path(__file__):
            assert not re.search(r"mark\.(e2e|m7|browser|last|fuzz)|time\.sleep|given\(", text), (
                file
            )
