"""Runs the core's own tests against mutants of it, a forked process each."""

from __future__ import annotations

import importlib
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import CodeType, ModuleType

from gazesetup import ROOT

TESTS = ROOT / "tests" / "firmware"
SUITES = tuple(sorted(path.stem for path in TESTS.glob("board_core_*.py")))
MUTANT_LIMIT_S = 20.0

# Exit codes of a mutant's process; below these: the index of the test that killed it.
_SURVIVED = 255
_BROKEN = 254

Test = Callable[[], None]


def source_of(module: str) -> str:
    """Text of a module of the firmware's core: "safety" or "motion"."""
    return (ROOT / "firmware" / "gazeboard" / f"{module}.py").read_text()


def timed_order() -> list[tuple[str, str]]:
    """The suites' tests as (suite, name), fastest first. Raises AssertionError when one fails."""
    answer, report = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(answer)
        code = 1
        with suppress(BaseException):
            took = []
            for suite, name, test in _load():
                start = time.perf_counter()
                test()
                took.append((time.perf_counter() - start, suite, name))
            lines = "\n".join(f"{suite} {name}" for _, suite, name in sorted(took))
            os.write(report, lines.encode())
            code = 0
        os._exit(code)
    os.close(report)
    with os.fdopen(answer) as pipe:
        text = pipe.read()
    _, status = os.waitpid(pid, 0)
    assert status == 0, "the core's tests fail without any mutant: run pytest tests/firmware"
    return [(line.split()[0], line.split()[1]) for line in text.splitlines()]


def survives(module: str, code_of_mutant: CodeType, order: list[tuple[str, str]]) -> bool:
    """True when every test passes with the module replaced by the mutant.

    The test that kills it moves to the front of `order`: it kills the mutant's neighbours too.
    """
    pid = os.fork()
    if pid == 0:
        code = _BROKEN
        with suppress(BaseException):
            # A mutant may loop for ever; counted in its own time, however busy the machine is.
            signal.setitimer(signal.ITIMER_VIRTUAL, MUTANT_LIMIT_S)
            target = importlib.import_module(f"gazeboard.{module}")
            for name in [name for name in vars(target) if not name.startswith("__")]:
                delattr(target, name)
            exec(code_of_mutant, vars(target))
            tests = {(suite, name): test for suite, name, test in _load()}
            for code, key in enumerate(order):  # noqa: B007 - its last value is the answer
                tests[key]()
            code = _SURVIVED
        os._exit(code)
    _, status = os.waitpid(pid, 0)
    code = os.waitstatus_to_exitcode(status)
    if 0 < code < len(order):
        order.insert(0, order.pop(code))
    return code == _SURVIVED


def _load() -> list[tuple[str, str, Test]]:
    """Import the suites afresh: called in a forked process only."""
    for folder in (TESTS, TESTS.parent):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
    tests: list[tuple[str, str, Test]] = []
    for suite in SUITES:
        module: ModuleType = importlib.import_module(suite)
        names = [name for name in vars(module) if name.startswith("test_")]
        tests += [(suite, name, getattr(module, name)) for name in names]
    return tests


def suite_files() -> list[Path]:
    """Files of the tests that mutants must not survive."""
    return [TESTS / f"{suite}.py" for suite in SUITES]
