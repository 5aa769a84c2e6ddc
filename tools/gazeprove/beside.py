"""Proves parts one after the other, those that leave cores idle beside the others.

These come first and the others give way to them, because the emulated board lives in real time. So
each core has work until the end, and what is counted in processor time stays what it is.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from gazeprove import faster, record
from gazesetup import note, say, source_environment
from gazesetup.family import dies_with_me

Results = dict[str, dict[str, Any]]  # the figures of each part

# One emulation at a time; and few tests that take very long.
BESIDE = ("emulated", "longest")
_GIVES_WAY = 10  # nice


def prove(parts: Sequence[str], quick: bool) -> tuple[Results, list[str]]:
    """The figures of each part, in this order, and what fell short."""
    others = [part for part in parts if part not in BESIDE]
    if quick or len(others) in (0, len(parts)):
        return _in_turn(parts, quick)
    with tempfile.TemporaryDirectory() as folder:
        answer = Path(folder) / "answer"
        words: list[str | Path] = [sys.executable, "-m", __name__, answer]
        words += [part for part in parts if part in BESIDE]
        with subprocess.Popen(
            words,
            env=source_environment(),
            preexec_fn=dies_with_me(signal.SIGTERM),
        ) as there:
            try:
                os.nice(_GIVES_WAY)
                results, short = _in_turn(others, quick)
                code = there.wait()
            except BaseException:
                there.terminate()
                raise
        if code or not answer.exists():
            return results, [*short, f"the parts beside the others ended with {code}"]
        figures, missing = json.loads(answer.read_text())
    results.update(figures)
    return {part: results[part] for part in parts}, [*short, *missing]


def _in_turn(parts: Sequence[str], quick: bool) -> tuple[Results, list[str]]:
    results: Results = {}
    short: list[str] = []
    for part in parts:
        results[part], missing = _one(part, quick)
        short += [f"{part}: {text}" for text in missing]
    return results, short


def _one(part: str, quick: bool) -> tuple[dict[str, Any], list[str]]:
    """One part: its figures and what fell short; the full form goes into the record."""
    files = record.files_of(part)
    started, used = time.monotonic(), _processor_s()
    with say(part):
        found, short = faster.run(part, quick, lambda text: note(f"{part}: {text}"))
    figures = {
        **found,
        "seconds": round(time.monotonic() - started, 1),
        "processor_seconds": round(_processor_s() - used, 1),
    }
    if record.files_of(part) != files:
        short = [*short, "a file changed while it was being proven"]
    if not quick:
        record.write(part, figures, short, files)
    return figures, short


def _processor_s() -> float:
    """Time of this process and of those that it waited for."""
    return sum(os.times()[:4])


def _there(answer: str, *parts: str) -> None:
    Path(answer).write_text(json.dumps(_in_turn(parts, False)))


if __name__ == "__main__":
    _there(*sys.argv[1:])
