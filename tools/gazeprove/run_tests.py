"""Runs the modules' own tests once: how long each takes, and which statements it runs."""

from __future__ import annotations

import functools
import importlib
import os
import pickle
import sys
import time
import traceback
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

from gazeprove.modules import MODULES, SUITES, TESTS
from gazeprove.statements import Mark, Marked

Name = tuple[str, str]  # of a test: suite, function


@dataclass
class Ran:
    """What one run of all tests came to."""

    places: list[Mark] = field(default_factory=list)
    loading: set[Mark] = field(default_factory=set)  # ran while the suites were loaded
    by_test: dict[Name, set[Mark]] = field(default_factory=dict)
    seconds: dict[Name, float] = field(default_factory=dict)  # processor time
    failed: str = ""

    def runs_loading(self, module: str, line: int) -> bool:
        """Whether the statement at this line runs while the suites are loaded."""
        return Mark(module, line, "") in self.loading

    def fastest_first(self) -> list[Name]:
        """All tests."""
        return sorted(self.seconds, key=self.seconds.__getitem__)


@functools.cache
def run_tests() -> Ran:
    """Run all suites once, in processes of their own. Raises RuntimeError when a test fails."""
    processes = os.cpu_count() or 1
    running = [_begin(number, processes) for number in range(processes)]
    found = Ran()
    for pid, answer in running:
        with os.fdopen(answer, "rb") as pipe:
            part: Ran = pickle.load(pipe)
        os.waitpid(pid, 0)
        found.places = part.places
        found.loading |= part.loading
        found.by_test |= part.by_test
        found.seconds |= part.seconds
        found.failed = found.failed or part.failed
    if found.failed:
        raise RuntimeError(f"the modules' own tests fail without any mutant:\n{found.failed}")
    return found


def _begin(number: int, processes: int) -> tuple[int, int]:
    """A process that runs every so many-th test: its number, and where it reports."""
    answer, report = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.close(answer)
        ran = Ran()
        try:
            _run(ran, number, processes)
        except BaseException:
            ran.failed = traceback.format_exc()
        with os.fdopen(report, "wb") as pipe:
            pickle.dump(ran, pipe)
        os._exit(0)
    os.close(report)
    return pid, answer


def _run(ran: Ran, number: int, processes: int) -> None:
    marked = Marked(tuple(MODULES))
    ran.places = marked.places
    marked.install()
    suites = {name: suite(name) for name in SUITES}
    ran.loading = marked.ran()
    tests = [(name, test) for name, module in suites.items() for test in _names(module)]
    for name, test in tests[number::processes]:
        start = time.process_time()
        call(suites[name], test)
        ran.seconds[name, test] = time.process_time() - start
        ran.by_test[name, test] = marked.ran()


def _names(module: ModuleType) -> list[str]:
    """The module's tests; with a parameter, one for each of its values: `test_name[2]`."""
    names = []
    for name, function in vars(module).items():
        if name.startswith("test_"):
            values = _values(function)
            names += [name] if values is None else [f"{name}[{at}]" for at in range(len(values))]
    return names


def call(module: ModuleType, name: str) -> None:
    """Run one test of a suite."""
    plain, _, at = name.rstrip("]").partition("[")
    function = getattr(module, plain)
    values = _values(function)
    if values is None:
        function()
    else:
        function(values[int(at)])


def _values(function: Any) -> list[Any] | None:
    """What pytest gives the test, one after the other; None: nothing."""
    marks = [mark for mark in getattr(function, "pytestmark", ()) if mark.name == "parametrize"]
    return list(marks[0].args[1]) if marks else None


def suite(name: str) -> ModuleType:
    """Import a suite: only in a process that ends with what it did."""
    for folder in (TESTS, TESTS.parent):
        if str(folder) not in sys.path:
            sys.path.insert(0, str(folder))
    return importlib.import_module(name)
