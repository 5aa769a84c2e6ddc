"""Checks for allocation: ticks with live link traffic and fuzz bytes, with a locked heap."""

from __future__ import annotations

import subprocess
from pathlib import Path

import gazesetup
from gazemeasure.report import Report

_TICKS = 1_000_000
_TICKS_QUICK = 50_000
_FUZZ = 10_000_000
_FUZZ_QUICK = 500_000
_LIMIT_S = 3000.0


def add_to(report: Report, quick: bool) -> None:
    """Run both and add their figures."""
    ticks, fuzz = (_TICKS_QUICK, _FUZZ_QUICK) if quick else (_TICKS, _FUZZ)
    micropython = gazesetup.ensure_micropython()
    words = _run(micropython.path, ticks, fuzz)
    report.add("bytes allocated under heap_lock", words["allocated"], "B", 0)
    report.add("ticks under heap_lock", words["ticks"], "", ticks, at_least=True)
    report.add("states of board x motion reached", words["reached"], "", 8, at_least=True)
    report.add("fuzz bytes into the link", words["fuzz"], "B", fuzz, at_least=True)
    report.add("exceptions in the fuzz", words["exceptions"], "", 0)
    report.add("motions in the fuzz", words["motions"], "", 0)
    report.add("counters wrong after the fuzz", words["counters_wrong"], "", 0)
    report.note(f"allocation and fuzz: {micropython.description}")


def _run(micropython: Path, ticks: int, fuzz: int) -> dict[str, int]:
    env = gazesetup.source_environment()
    program = Path(__file__).parent / "board_allocation_load.py"
    result = subprocess.run(
        [str(micropython), "-X", "heapsize=2m", str(program), str(ticks), str(fuzz)],
        env=env,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=_LIMIT_S,
    )
    if result.returncode:
        raise RuntimeError(f"the run on MicroPython failed: {result.stderr[-600:]}")
    last = result.stdout.strip().splitlines()[-1]
    return {key: int(value) for key, value in (word.split("=") for word in last.split())}
