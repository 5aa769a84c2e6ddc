"""Runs the modules' own tests against mutants of them, a forked process each."""

from __future__ import annotations

import gc
import importlib
import mmap
import os
import signal
import struct
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from types import FunctionType, ModuleType

from gazeprove.modules import MODULES, SUITES, TESTS
from gazeprove.mutate import Mutant
from gazeprove.run_tests import Name, Ran, call, suite
from gazeprove.statements import serve

# A test that takes so much longer than without a mutant does not end: processor time.
_TIMES_AS_LONG = 5
_AND_S = 0.5
_LOADING_LIMIT_S = 20.0
# Of a mutant that is listed as equivalent, the tests that take this long at most, in all.
_QUICK_S = 0.02
_QUICK_ALL_S = 1.0

_ANYWHERE = ""  # in a module
_NEIGHBOURS = 5

# What a mutant's process is at; from 0 on: the number of the test that runs.
_BEGUN, _LOADING, _PASSED = -3, -2, -1
_STORED = struct.Struct("i")


@dataclass
class Killer:
    """Tries mutants, the tests that killed their neighbours first."""

    ran: Ran
    _by_line: dict[tuple[str, int], list[Name]] = field(default_factory=dict)
    _by_module: dict[str, list[Name]] = field(default_factory=dict)
    _killed: dict[tuple[str, str], list[Name]] = field(default_factory=dict)
    _at: mmap.mmap = field(default_factory=lambda: mmap.mmap(-1, _STORED.size))

    def __post_init__(self) -> None:
        for test in self.ran.fastest_first():
            places = self.ran.by_test[test]
            for line in {(place.module, place.line) for place in places if not place.way}:
                self._by_line.setdefault(line, []).append(test)
            for module in {place.module for place in places}:
                self._by_module.setdefault(module, []).append(test)
        for name in SUITES:
            suite(name)
        gc.freeze()  # a process for each mutant shares what there is

    def survives(self, module: str, mutant: Mutant, listed: bool = False) -> bool:
        """True when every test passes that runs what the mutant changes."""
        return self.killed_by(module, mutant, listed) is None

    def killed_by(
        self, module: str, mutant: Mutant, listed: bool = False, first: Name | None = None
    ) -> Name | None:
        """A test that fails, of those that run what the mutant changes; `first` is tried first.

        `listed` tries quick tests only: it is known why none can kill it.
        """
        if not mutant.path:
            tests, put_in = self._by_module[module], _replace_module
        else:
            if self.ran.runs_loading(module, mutant.line):
                raise RuntimeError(f"{module}.py:{mutant.line} runs before any test begins")
            tests, put_in = self._by_line.get((module, mutant.line), []), _replace_function
        tried = self._quick(tests) if listed else self._ordered(module, mutant, tests, first)
        by = self._killer(lambda: put_in(module, mutant), tried)
        if by is not None:
            for of in ((module, mutant.where), (module, _ANYWHERE)):
                known = self._killed.setdefault(of, [])
                with suppress(ValueError):
                    known.remove(by)
                known.insert(0, by)
        return by

    def _quick(self, tests: Sequence[Name]) -> list[Name]:
        """The fastest of them, within what a listed mutant may take."""
        chosen = []
        left_s = _QUICK_ALL_S
        for test in tests:
            left_s -= self.ran.seconds[test]
            if left_s > 0 and self.ran.seconds[test] <= _QUICK_S:
                chosen.append(test)
        return chosen

    def _ordered(
        self, module: str, mutant: Mutant, tests: Sequence[Name], first: Name | None
    ) -> list[Name]:
        """`first`, those that killed in the same function, then in the module, then the fastest."""
        near = self._killed.get((module, mutant.where), [])
        known = [*near, *self._killed.get((module, _ANYWHERE), [])[:_NEIGHBOURS]]
        able = set(tests)
        order = dict.fromkeys(((first,) if first else ()) + (*known, *tests))
        return [test for test in order if test in able]

    def _killer(self, put_in: Callable[[], None], tests: Sequence[Name]) -> Name | None:
        """The test that fails, or None. Raises RuntimeError when the mutant cannot be put in."""
        if not tests:
            return None
        self._say(_BEGUN)
        pid = os.fork()
        if pid == 0:
            with suppress(BaseException):
                gc.disable()
                put_in()
                for number, test in enumerate(tests):
                    self._run(number, test)
                self._say(_PASSED)
            os._exit(0)
        os.waitpid(pid, 0)
        at: int = _STORED.unpack(self._at[:])[0]
        if at == _BEGUN:
            raise RuntimeError("a mutant was not put in")
        if at == _PASSED:
            return None
        return tests[max(0, at)]

    def _run(self, number: int, test: Name) -> None:
        """Run one test, in the mutant's process; its end by the clock is an end of the process."""
        self._say(_LOADING)
        signal.setitimer(signal.ITIMER_VIRTUAL, _LOADING_LIMIT_S)
        module = suite(test[0])
        self._say(number)
        signal.setitimer(signal.ITIMER_VIRTUAL, _TIMES_AS_LONG * self.ran.seconds[test] + _AND_S)
        call(module, test[1])
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)

    def _say(self, number: int) -> None:
        self._at[:] = _STORED.pack(number)


def _replace_function(module: str, mutant: Mutant) -> None:
    """Everybody who has the function has the mutant: only its code is another."""
    found: object = importlib.import_module(MODULES[module])
    for name in mutant.path:
        found = vars(found)[name]
    assert isinstance(found, FunctionType)
    found.__code__ = mutant.code


def _replace_module(module: str, mutant: Mutant) -> None:
    """Everybody loads the mutant for the module, and everything that uses it anew."""
    for name in [name for name, found in sys.modules.items() if _is_of_the_tests(name, found)]:
        del sys.modules[name]
    serve({module: mutant.code}, {})


def _is_of_the_tests(name: str, module: ModuleType) -> bool:
    """A suite, what suites share, or the virtual chair they drive: each may hold the original."""
    file = getattr(module, "__file__", None) or ""
    return file.startswith(f"{TESTS.parent}/") or name.partition(".")[0] == "gazesim"
