"""Runs a part of the proof in PyPy, which takes half the time or less, if the machine can."""

from __future__ import annotations

import functools
import json
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from gazeprove.parts import PARTS
from gazeprove.pools import Note, Part
from gazesetup import NotAvailable, ensure_pypy, note, source_environment
from gazesetup.family import dies_with_me

# What needs neither the tests' libraries nor many short processes.
FASTER = frozenset({"enumeration", "everything at once", "decisions", "fuzz"})


def run(part: str, quick: bool, note: Note) -> Part:
    """The part's figures and what fell short; `figures` names the interpreter when it is PyPy."""
    pypy = None if quick or part not in FASTER else _pypy()
    if pypy is None:
        return PARTS[part](quick, note)
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer"
        words: list[str | Path] = [pypy, "-m", "gazeprove.faster", part, answer]
        ends = dies_with_me(signal.SIGTERM)
        code = subprocess.run(words, env=source_environment(), preexec_fn=ends).returncode
        if code or not answer.exists():
            return {}, [f"PyPy ended with {code}"]
        figures, short = json.loads(answer.read_text())
    return {**figures, "interpreter": "PyPy"}, short


@functools.cache
def _pypy() -> Path | None:
    try:
        return ensure_pypy()
    except NotAvailable as error:
        note(f"no PyPy ({error}): this takes twice as long")
        return None


def _here(part: str, answer: str) -> None:
    Path(answer).write_text(json.dumps(PARTS[part](False, note)))


if __name__ == "__main__":
    _here(*sys.argv[1:])
