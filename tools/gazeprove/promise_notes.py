"""What the tests of the safety promises noted while they ran (tests/promises.py)."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from gazesetup import ROOT

# Names the folder for the notes, one file per process.
FOLDER_IN = "GAZECHAIR_PROMISES"
_NOTES = "from promises import "  # in each test file that notes a promise

Note = dict[str, Any]


def noting(files: Iterable[Path]) -> list[str]:
    """Those whose tests note what they measured, relative to the checkout."""
    return [str(f.relative_to(ROOT)) for f in sorted(files) if _NOTES in f.read_text()]


def read(folder: Path) -> list[Note]:
    """All notes in `folder`."""
    notes: list[Note] = []
    for path in sorted(folder.glob("*.json")):
        notes += json.loads(path.read_text())
    return notes


def worst(notes: Iterable[Note]) -> list[Note]:
    """Of what a test noted several times, the longest time."""
    found: dict[tuple[Any, ...], Note] = {}
    for note in notes:
        key = tuple(note[name] for name in ("rig", "promise", "cause", "limit_ms", "test"))
        known = found.setdefault(key, note)
        if note["ms"] is not None and (known["ms"] is None or note["ms"] > known["ms"]):
            found[key] = note
    return [found[key] for key in sorted(found, key=str)]
