"""Which parts of the proof run beside the others, and what comes of one that fails there."""

from __future__ import annotations

import json
import sys
import threading
from pathlib import Path
from typing import Any

import pytest

from gazeprove import beside, record
from gazeprove.parts import PARTS

ALL = ("mutation", "emulated", "longest", "costly")


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> dict[str, dict[str, Any]]:
    """Every part falls short of something; the rows that were written."""
    written: dict[str, dict[str, Any]] = {}
    for name in PARTS:
        monkeypatch.setitem(PARTS, name, lambda quick, note: ({"quick": quick}, ["one"]))
    monkeypatch.setattr(record, "files_of", lambda part: {})
    monkeypatch.setattr(
        record, "write", lambda part, figures, short, files: written.update({part: figures})
    )
    monkeypatch.setattr("os.nice", lambda by: 0)
    return written


def answering(path: Path, monkeypatch: pytest.MonkeyPatch, does: str) -> None:
    """A Python: called as PYTHON -m gazeprove.beside ANSWER PART ..."""
    python = path / "python"
    python.write_text(f"#!/bin/sh\n{does}\n")
    python.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(python))


def test_they_run_there_and_the_figures_keep_their_order(
    parts: dict[str, dict[str, Any]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    answer = json.dumps([{"emulated": {"tests": 3}, "longest": {}}, ["emulated: one broken"]])
    right = 'test "$2 $4 $5" = "gazeprove.beside emulated longest"'
    answering(tmp_path, monkeypatch, f"echo '{answer}' > \"$3\"; {right}")
    results, short = beside.prove(ALL, False)
    assert tuple(results) == ALL
    assert results["emulated"] == {"tests": 3}
    assert short == ["mutation: one", "costly: one", "emulated: one broken"]
    assert set(parts) == {"mutation", "costly"}


@pytest.mark.usefixtures("parts")
@pytest.mark.parametrize("does", ["exit 3", "true", "echo '[{}, []]' > \"$3\"; exit 1"])
def test_parts_that_fail_there_prove_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, does: str
) -> None:
    answering(tmp_path, monkeypatch, does)
    results, short = beside.prove(ALL, False)
    assert set(results) == {"mutation", "costly"}
    assert len(short) == 3


@pytest.mark.parametrize(
    ("chosen", "quick"), [(ALL, True), (("mutation",), False), (("longest", "emulated"), False)]
)
def test_with_nothing_to_run_beside_all_run_here(
    parts: dict[str, dict[str, Any]],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    chosen: tuple[str, ...],
    quick: bool,
) -> None:
    answering(tmp_path, monkeypatch, "exit 3")
    results, short = beside.prove(chosen, quick)
    assert tuple(results) == chosen
    assert short == [f"{part}: one" for part in chosen]
    assert tuple(parts) == (() if quick else chosen)


def test_what_runs_there_is_recorded_and_answered(
    parts: dict[str, dict[str, Any]], tmp_path: Path
) -> None:
    beside._there(str(tmp_path / "answer"), "longest")
    figures, short = json.loads((tmp_path / "answer").read_text())
    assert figures["longest"] == parts["longest"]
    assert short == ["longest: one"]


def test_two_that_write_the_record_at_once_lose_no_row(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    file = tmp_path / "proof.json"
    other = threading.Thread(target=record.write, args=("longest", {}, [], {"b.py": "1"}, file))
    read = record.read

    def slowly(file: Path) -> dict[str, Any]:
        found = read(file)
        monkeypatch.setattr(record, "read", read)
        other.start()
        other.join(0.2)  # it would be done by now, did it not wait
        return found

    monkeypatch.setattr(record, "read", slowly)
    record.write("fuzz", {}, [], {"a.py": "1"}, file)
    other.join()
    assert set(read(file)["parts"]) == {"fuzz", "longest"}
