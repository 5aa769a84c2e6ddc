"""The part that runs what computes for long in virtual time: the tests marked `costly`.

They depend on nearly every file, and on nothing else: neither on a clock nor on the machine.
`tools/test` runs them whenever one of those files differs from the record.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
from importlib import metadata
from pathlib import Path

from gazeprove import promise_notes
from gazeprove.pools import Note, Part
from gazeprove.programs import finish
from gazesetup import ROOT, ensure_micropython, source_environment

NAME = "costly"  # the part and the tests' mark
_MARKS = f"{NAME} and not (recorded or long)"
_TESTS = ROOT / "tests"
# Of the pages only the texts count: none of these tests opens one.
_ROOTS = ("firmware", "protocol", "host", "tools", "tests", "web", "web/strings")
_NOT = ("tests/web", "tools/gazesetup")
_SUFFIXES = (".py", ".json", ".toml", ".txt")
_SHOWN_LINES = 40


def costly(quick: bool, note: Note) -> Part:
    """Run them; what they measured of the safety promises is part of the figures."""
    marked = [f for f in _TESTS.rglob("test_*.py") if f"mark.{NAME}" in f.read_text()]
    with tempfile.TemporaryDirectory() as folder:
        env = {**source_environment(), promise_notes.FOLDER_IN: folder}
        env["PYTHONPATH"] += os.pathsep + str(_TESTS)
        env["GAZECHAIR_MICROPYTHON"] = str(ensure_micropython().path)
        words = ["-q", "-p", "promises", "--dist", "loadgroup", "-n", str(os.cpu_count() or 1)]
        selected = ["-m", _MARKS, *map(str, sorted(marked))]
        done = finish([sys.executable, "-m", "pytest", *words, *selected], ROOT, env)
        notes = promise_notes.worst(promise_notes.read(Path(folder)))
    passed = re.search(r"(\d+) passed", done.stdout)
    figures = {"tests": int(passed[1]) if passed else 0, "notes": notes}
    whole = done.returncode == 0 and passed and "skipped" not in done.stdout
    return figures, [] if whole else done.stdout.splitlines()[-_SHOWN_LINES:]


def digests() -> dict[str, str]:
    """The digest of each folder's own files; and which Python and numpy they run on."""
    found = {
        "Python": f"{sys.version_info.major}.{sys.version_info.minor}",
        "numpy": metadata.version("numpy"),
        "pyproject.toml": _digest([ROOT / "pyproject.toml"]),
    }
    for root in _ROOTS:
        for folder in (ROOT / root, *sorted((ROOT / root).rglob("*"))):
            name = str(folder.relative_to(ROOT))
            if folder.is_dir() and not name.startswith(_NOT):
                files = sorted(file for file in folder.iterdir() if file.suffix in _SUFFIXES)
                found |= {name: _digest(files)} if files else {}
    return found


def _digest(files: list[Path]) -> str:
    whole = hashlib.sha256()
    for file in files:
        whole.update(f"{file.name} {hashlib.sha256(file.read_bytes()).hexdigest()}\n".encode())
    return whole.hexdigest()[:16]
