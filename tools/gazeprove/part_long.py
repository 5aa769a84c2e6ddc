"""The parts that run tests which would take too long, or another machine, each time."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from gazeprove import promise_notes
from gazeprove.pools import Note, Part
from gazeprove.programs import finish
from gazesetup import (
    ROOT,
    NotAvailable,
    ensure_micropython,
    ensure_pypy,
    ensure_qemu,
    ensure_wasm,
    source_environment,
)

_TESTS = ROOT / "tests"
_FLASHED = _TESTS / "host" / "service" / "test_flash_calls.py"
_WASM = _TESTS / "tools" / "test_on_wasm.py"
_EMULATED = _TESTS / "board"
_FIRMWARE = _TESTS / "firmware"
_ON_PYPY = _TESTS / "onpypy.py"


def as_flashed(quick: bool, note: Note) -> Part:
    """Every test of the firmware on 32-bit MicroPython, with the texts as they are flashed."""
    found = ensure_micropython()
    figures, short = _run(_FLASHED, {"GAZECHAIR_MICROPYTHON": str(found.path)})
    return {**figures, "interpreter": found.description.partition(",")[0]}, short


def webassembly(quick: bool, note: Note) -> Part:
    """Every test that runs on a board, on a newer MicroPython, whose viper code is plain Python."""
    note(str(ensure_wasm()))
    return _run(_WASM, {})


def emulated(quick: bool, note: Note) -> Part:
    """Flashing, calibrating, the link and the promises on emulated boards, in real time."""
    note(str(ensure_qemu()))
    return _run(_EMULATED, {})


def longest(quick: bool, note: Note) -> Part:
    """Tests of the firmware of which `tools/test` runs some cases only."""
    return _run(_FIRMWARE, {}, marks="recorded and not long")


def promises(quick: bool, note: Note) -> Part:
    """What the firmware keeps of the safety promises, measured: docs/safety.md is made of it."""
    with tempfile.TemporaryDirectory() as folder:
        env = {**source_environment(), promise_notes.FOLDER_IN: folder}
        env["PYTHONPATH"] += os.pathsep + str(_TESTS)
        commands = _measure(note)
        with ThreadPoolExecutor() as pool:
            done = list(pool.map(lambda words: finish(words, ROOT, env), commands))
        notes = promise_notes.worst(promise_notes.read(Path(folder)))
    short = [line for one in done if one.returncode for line in one.stdout.splitlines()[-30:]]
    return {"tests": len({one["test"] for one in notes}), "notes": notes}, short


def begins() -> dict[str, tuple[Path, ...]]:
    """Where the imports begin of what each of these parts proves."""
    here = (Path(__file__), *(ROOT / "firmware" / "gazeboard").rglob("*.py"))
    board = (*here, *sorted(_TESTS.glob("*/board_*.py")), _TESTS / "boardtest.py")
    return {
        "as flashed": (*board, _FLASHED),
        "webassembly": (*board, _TESTS / "onwasm.mjs", _WASM),
        "emulated": (*here, *sorted(_EMULATED.glob("*.py"))),
        "longest": (*here, *sorted(_FIRMWARE.glob("test_*.py"))),
        "promises": (*board, _ON_PYPY),
    }


def _measure(note: Note) -> list[list[str]]:
    """The commands that run the tests, in PyPy where it can be had: a quarter of the time."""
    files = promise_notes.noting(_FIRMWARE.glob("board_*.py"))
    processes = os.cpu_count() or 1
    try:
        pypy = ensure_pypy()
    except NotAvailable as error:
        note(f"no PyPy ({error}): this takes four times as long")
        return [
            [sys.executable, "-m", "pytest", "-q", "-p", "promises", "-n", str(processes), *files]
        ]
    # All in a few processes: what is compiled for one file serves the next.
    return [[str(pypy), "-m", "onpypy", *files[n::processes]] for n in range(processes)]


def _run(
    tests: Path,
    also: dict[str, str],
    # Those that are "long" repeat what another part or test runs.
    marks: str = "not long",
) -> Part:
    processes = str(os.cpu_count() or 1)
    words = [sys.executable, "-m", "pytest", "-q", "-n", processes, "-m", marks, str(tests)]
    done = finish(words, ROOT, {**source_environment(), **also})
    passed = re.search(r"^(?:.* )?(\d+) passed", done.stdout, re.MULTILINE)
    figures = {"tests": int(passed[1]) if passed else 0}
    if done.returncode or not passed or "skipped" in done.stdout:
        return figures, done.stdout.splitlines()[-30:]
    return figures, []
