"""Runs the core's own tests against mutants of it, a forked process each."""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

from gazeprove.mutate import Mutant
from gazesetup import ROOT

TESTS = ROOT / "tests" / "firmware"
SUITES = tuple(sorted(path.stem for path in TESTS.glob("board_core_*.py")))
MUTANT_LIMIT_S = 20.0
_QUICK_SHARE = 0.002  # of the time of all tests: what a quick one takes at most

# Exit codes of a mutant's process; below these: the index of the test that killed it.
_SURVIVED = 255
_BROKEN = 254

Test = Callable[[], None]


def source_of(module: str) -> str:
    """Text of a module of the firmware's core: "safety" or "motion"."""
    return (ROOT / "firmware" / "gazeboard" / "core" / f"{module}.py").read_text()


@dataclass
class Tests:
    """The suites' tests in the order in which they are tried, and what each of them calls."""

    order: list[tuple[str, str]]  # (suite, name)
    calls: dict[tuple[str, str], set[str]]  # "module.function" of the core
    seconds: dict[tuple[str, str], float]
    always: set[str]  # what is called while the suites are loaded: concerns every test

    def of(self, module: str, function: str, quick: bool = False) -> list[tuple[str, str]]:
        """Those that can tell a mutant of this function: all of them when none is known to.

        `quick` leaves out those that take long.
        """
        called = f"{module}.{function}"
        order = [test for test in self.order if not quick or self._is_quick(test)]
        if called in self.always:
            return order
        return [test for test in order if called in self.calls[test]] or order

    def killed(self, test: tuple[str, str]) -> None:
        """Try this one first, unless it takes long: it kills the mutant's neighbours too."""
        if self._is_quick(test):
            self.order.remove(test)
            self.order.insert(0, test)

    def _is_quick(self, test: tuple[str, str]) -> bool:
        return self.seconds[test] <= _QUICK_SHARE * sum(self.seconds.values())


def known_tests() -> Tests:
    """The suites' tests, fastest first. Raises AssertionError when one fails."""
    answer, report = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(answer)
        code = 1
        with suppress(BaseException):
            tests, always = _traced(_load)
            took = []
            for suite, name, test in tests:
                start = time.perf_counter()
                _, calls = _traced(test)
                took.append((time.perf_counter() - start, suite, name, sorted(calls)))
            with os.fdopen(report, "w") as pipe:
                json.dump({"always": sorted(always), "took": sorted(took)}, pipe)
            code = 0
        os._exit(code)
    os.close(report)
    with os.fdopen(answer) as pipe:
        text = pipe.read()
    _, status = os.waitpid(pid, 0)
    assert status == 0, "the core's tests fail without any mutant: run pytest tests/firmware"
    known = json.loads(text)
    by_test = {(suite, name): set(called) for _, suite, name, called in known["took"]}
    seconds = {(suite, name): took for took, suite, name, _ in known["took"]}
    return Tests(list(by_test), by_test, seconds, set(known["always"]))


def _traced(work: Callable[[], Any]) -> tuple[Any, set[str]]:
    """What `work` returns, and the functions of the core that it calls."""
    called: set[CodeType] = set()

    def on_event(frame: FrameType, event: str, _argument: object) -> None:
        if event == "call":
            called.add(frame.f_code)

    sys.setprofile(on_event)
    try:
        result = work()
    finally:
        sys.setprofile(None)
    core = {code for code in called if "/gazeboard/core/" in code.co_filename}
    return result, {f"{Path(code.co_filename).stem}.{code.co_name}" for code in core}


def survives(module: str, mutant: Mutant, tests: Tests, quick: bool = False) -> bool:
    """True when every test passes with the module replaced by the mutant.

    `quick` tries the quick tests only: for a mutant of which it is known why none can kill it.
    """
    tried = tests.of(module, mutant.where, quick)
    pid = os.fork()
    if pid == 0:
        code = _BROKEN
        with suppress(BaseException):
            # A mutant may loop for ever; counted in its own time, however busy the machine is.
            signal.setitimer(signal.ITIMER_VIRTUAL, MUTANT_LIMIT_S)
            _forget_the_core()
            target = importlib.import_module(f"gazeboard.core.{module}")
            for name in [name for name in vars(target) if not name.startswith("__")]:
                delattr(target, name)
            exec(mutant.code, vars(target))
            for code, (suite, name) in enumerate(tried):  # noqa: B007 - its last is the answer
                getattr(_suite(suite), name)()
            code = _SURVIVED
        os._exit(code)
    _, status = os.waitpid(pid, 0)
    code = os.waitstatus_to_exitcode(status)
    if 0 <= code < len(tried):
        tests.killed(tried[code])
    return code == _SURVIVED


def _forget_the_core() -> None:
    """What is imported from now on takes the mutant for the module."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "gazeboard"]:
        del sys.modules[name]


def _load() -> list[tuple[str, str, Test]]:
    """All tests of the suites."""
    tests: list[tuple[str, str, Test]] = []
    for suite in SUITES:
        module = _suite(suite)
        names = [name for name in vars(module) if name.startswith("test_")]
        tests += [(suite, name, getattr(module, name)) for name in names]
    return tests


def _suite(name: str) -> ModuleType:
    """Import a suite afresh: called in a forked process only."""
    for folder in (TESTS, TESTS.parent):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
    return importlib.import_module(name)


def suite_files() -> list[Path]:
    """Files of the tests that mutants must not survive."""
    return [TESTS / f"{suite}.py" for suite in SUITES]
