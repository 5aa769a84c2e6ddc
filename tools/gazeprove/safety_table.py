"""Makes docs/safety.md out of what the tests of the promises measure."""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

from gazelink import codes
from gazeprove import part_costly, promise_notes, record, record_file
from gazeprove.promise_notes import Note
from gazeprove.safety_texts import (
    ARMING,
    CLEARS,
    FAULTS,
    INTRODUCTION,
    NOT_COVERED,
    PROMISES,
    Promise,
)
from gazesetup import ROOT, source_environment

DOCUMENT = ROOT / "docs" / "safety.md"
# The process tests prove that it is real; their times depend on the PC.
WITHOUT = "not e2e"
LIMIT_S = 1800
CORE = "core"
END_TO_END = "end to end"


class TestsFailed(Exception):
    """A promise is not kept: there is nothing to write down."""


def recorded_notes() -> list[Note]:
    """What the tests that are on record measured when they last ran (docs/proof.json)."""
    found = record_file.read()
    notes: list[Note] = found["parts"]["promises"]["figures"]["notes"]
    if not record.why_not_now(part_costly.NAME):
        notes = [*notes, *found["parts"][part_costly.NAME]["figures"]["notes"]]
    return notes


def run_tests() -> list[Note]:
    """Run every other test of the promises; what all of them noted. Raises TestsFailed."""
    tests = [f for f in (ROOT / "tests").rglob("*.py") if not f.name.startswith("board_")]
    with tempfile.TemporaryDirectory() as folder:
        env = source_environment()
        env[promise_notes.FOLDER_IN] = folder
        env["PYTHONPATH"] = os.pathsep.join([env["PYTHONPATH"], str(ROOT / "tests")])
        words = ["-m", "pytest", "-q", "-n", "auto", "-p", "promises", "-m", WITHOUT]
        # The document's own test would only start all this again.
        words += ["--deselect", "tests/e2e/test_safety_table.py", *promise_notes.noting(tests)]
        done = subprocess.run(
            [sys.executable, *words],
            cwd=ROOT,
            env=env,
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
        )
        if done.returncode:
            raise TestsFailed("\n".join(done.stdout.splitlines()[-15:]) + done.stderr)
        return [*recorded_notes(), *promise_notes.read(Path(folder))]


def render(notes: list[Note]) -> str:
    """The whole document."""
    parts = [
        "# Safety: what is promised, and what was measured",
        INTRODUCTION,
        "## Promises",
        _promises(notes),
        "## Arming",
        "Driving is switched on only when all of this holds; else the page says what is missing.",
        _table(("What must hold", "What the page says otherwise"), _arming()),
        _reasons(notes),
        "## Faults",
        FAULTS,
        _table(("Fault", "Severity", "Latched", "Clears", "Text", "What to do"), _faults()),
        "## Not covered",
        NOT_COVERED,
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _promises(notes: list[Note]) -> str:
    head = ("#", "Cause", "Action", "Promised", "Board", "End to end", "Tests")
    rows: list[tuple[str, ...]] = []
    known = homes()
    for promise in PROMISES:
        names = {note["test"] for note in notes if note["promise"] == promise.name}
        first = (f"**{promise.name}**", f"**{promise.cause}**", promise.action, promise.within)
        rows.append((*first, "", "", files_of(names, known)))
        for cause in _causes(notes, promise):
            rows.append(_row(notes, promise, cause))
    return _table(head, rows)


def homes() -> dict[str, list[str]]:
    """{name of a test: the files with one that notes a promise, below the checkout}."""
    found: dict[str, list[str]] = {}
    for file in promise_notes.noting((ROOT / "tests").rglob("*.py")):
        for name in re.findall(r"^def (test_\w+)", (ROOT / file).read_text("utf-8"), re.M):
            found.setdefault(name, []).append(file)
    return found


def files_of(names: Iterable[str], known: Mapping[str, list[str]]) -> str:
    """The files of these tests, for the promise's first row."""
    return ", ".join(sorted({f"`{file}`" for name in names for file in known.get(name, ())}))


def _causes(notes: list[Note], promise: Promise) -> list[str]:
    return sorted({note["cause"] for note in notes if note["promise"] == promise.name})


def _row(notes: list[Note], promise: Promise, cause: str) -> tuple[str, ...]:
    here = [n for n in notes if n["promise"] == promise.name and n["cause"] == cause]
    limits = {n["limit_ms"] for n in here if n["limit_ms"] is not None}
    assert len(limits) <= 1, f"{promise.name}, {cause}: several limits {limits}"
    names = sorted({f"`{note['test']}`" for note in here})
    limit = f"{limits.pop()} ms" if limits else "-"
    return ("", cause, "", limit, _worst(here, CORE), _worst(here, END_TO_END), ", ".join(names))


def _worst(notes: Iterable[Note], rig: str) -> str:
    here = [note for note in notes if note["rig"] == rig]
    times = [note["ms"] for note in here if note["ms"] is not None]
    if times:
        return f"{max(times)} ms"
    return "kept" if here else "-"


def _arming() -> list[tuple[str, str]]:
    texts = _texts()
    return [(condition, texts[reason]["text"]) for condition, reason in ARMING]


def _reasons(notes: list[Note]) -> str:
    here = [note for note in notes if note["promise"] == "arming"]
    names = ", ".join(sorted({f"`{note['test']}`" for note in here}))
    causes = ", ".join(sorted({note["cause"] for note in here}))
    return f"Proven end to end for: {causes} ({names})."


def _faults() -> list[tuple[str, ...]]:
    texts = _texts()
    rows: list[tuple[str, ...]] = []
    for _bit, name, severity, latched in codes.FAULTS:
        rows.append(
            (
                f"`{name}`",
                "error" if severity == codes.ERROR else "warning",
                "yes" if latched else "no",
                CLEARS[name],
                texts[name]["text"],
                texts[name]["do"],
            )
        )
    return rows


def _texts() -> dict[str, dict[str, str]]:
    strings = json.loads((ROOT / "web" / "strings" / "en.json").read_text())
    messages: dict[str, dict[str, str]] = strings["messages"]
    return messages


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    lines = [head, tuple("---" for _ in head)]
    lines += [(*row, *[""] * (len(head) - len(row))) for row in rows]
    return "\n".join("| " + " | ".join(cells) + " |" for cells in lines)


def main(arguments: list[str] | None = None) -> int:
    """0: written, or as it should be; 1: it was stale (--check), or a promise is not kept."""
    parser = argparse.ArgumentParser(prog="tools/safety-table", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; 1 when it is stale")
    check = parser.parse_args(arguments).check
    try:
        text = render(run_tests())
    except TestsFailed as failed:
        print(f"{failed}\nthe promises' tests failed: {DOCUMENT.name} is not written")
        return 1
    if check:
        fresh = DOCUMENT.exists() and DOCUMENT.read_text() == text
        print(f"{DOCUMENT.name}: " + ("up to date" if fresh else "stale; run tools/safety-table"))
        return 0 if fresh else 1
    DOCUMENT.write_text(text)
    print(f"{DOCUMENT.relative_to(ROOT)} written")
    return 0


if __name__ == "__main__":
    sys.exit(main())
