"""docs/safety.md says what the tests measured, no more and no less. Runs last: see conftest.py."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

import promises
from gazelink import codes
from gazeprove import promise_notes, safety_table
from gazeprove.safety_texts import ARMING, CLEARS, PROMISES
from gazesetup import ROOT


@pytest.mark.last
def test_the_document_is_what_the_tests_measure() -> None:
    text = safety_table.DOCUMENT.read_text()
    named = set(re.findall(r"`(test_\w+)`", text))
    folder = os.environ.get(promise_notes.FOLDER_IN)
    notes = promise_notes.read(Path(folder)) if folder else promises.notes
    notes = [*safety_table.recorded_notes(), *notes]
    if not named <= {note["test"] for note in notes}:
        notes = safety_table.run_tests()
    measured, written = _times(safety_table.render(notes)), _times(text)
    assert measured[0] == written[0], "docs/safety.md is stale: run tools/safety-table"
    apart = [pair for pair in zip(measured[1], written[1], strict=True) if _differ(*pair)]
    assert not apart, f"docs/safety.md is stale, ms measured and written: {apart}"


def _times(text: str) -> tuple[list[list[str]], list[int]]:
    """The cells of the document without the times that were measured; and those, in their order."""
    rows, times = [], []
    for line in text.splitlines():
        cells = line.split(" | ")
        for at in (4, 5) if len(cells) == 7 else ():
            if found := re.fullmatch(r"(\d+) ms", cells[at]):
                times.append(int(found[1]))
                cells[at] = "ms"
        rows.append(cells)
    return rows, times


def _differ(one_ms: int, other_ms: int) -> bool:
    """More than by one word of the parts that run beside the board, which come every 50 ms."""
    return abs(one_ms - other_ms) > 60


def test_every_promise_is_measured_on_the_board_and_end_to_end() -> None:
    text = safety_table.DOCUMENT.read_text()
    measured: dict[str, set[str]] = {}
    name = ""
    for line in text.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if found := re.fullmatch(r"\*\*(P\d+)\*\*", cells[0]):
            name = found[1]
        elif name and len(cells) == 7:
            for rig, cell in (("board", cells[4]), ("end to end", cells[5])):
                if cell != "-":
                    measured.setdefault(name, set()).add(rig)
    assert measured == {promise.name: {"board", "end to end"} for promise in PROMISES}


def test_every_promise_names_the_files_of_its_tests() -> None:
    known, at = safety_table.homes(), ""
    named: dict[str, set[str]] = {}
    for line in safety_table.DOCUMENT.read_text().partition("## Arming")[0].splitlines():
        if found := re.match(r"\| \*\*(P\d+)\*\* ", line):
            at = found[1]
            assert "`tests/" in line, at
        named.setdefault(at, set()).update(re.findall(r"`(tests/[\w/]+\.py|test_\w+)`", line))
    for promise in PROMISES:
        tests = {name for name in named[promise.name] if name in known}
        files = {name for name in named[promise.name] if name.startswith("tests/")}
        assert files == {file for name in tests for file in known[name]}
        assert tests | files == named[promise.name]


def test_every_fault_and_reason_is_explained() -> None:
    assert list(CLEARS) == [fault[1] for fault in codes.FAULTS]
    texts = json.loads((ROOT / "web" / "strings" / "en.json").read_text())["messages"]
    for name in [*CLEARS, *(reason for _, reason in ARMING)]:
        assert texts[name]["text"], name
