"""Which test killed each mutant when the record was made: what the next run tries first.

An order to try the tests in, no proof: a mutant counts as killed only by a test that fails now, and
one that the recorded test does not kill meets all others.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

from gazeprove.mutate import Mutant
from gazeprove.run_tests import Name

_NOBODY = "-"
_TIMES = "*"
_OF_SUITE = "::"


class Killers:
    """By module, function, and the mutant's number in that function."""

    def __init__(self) -> None:
        self._by: dict[tuple[str, str], dict[int, Name]] = {}

    def of(self, module: str, mutant: Mutant) -> Name | None:
        """The test that killed it, or the mutant that was here before the module changed."""
        return self._by.get((module, mutant.where), {}).get(mutant.number)

    def add(self, module: str, where: str, number: int, by: Name | None) -> None:
        """Keep one. None: nothing killed it."""
        if by is not None:
            self._by.setdefault((module, where), {})[number] = by

    def rows(self) -> list[str]:
        """For the record: the tests in one line each, then the functions with their tests' numbers.

        "3*4" is four times test 3 in a row.
        """
        tests = sorted({test for of in self._by.values() for test in of.values()})
        at = {test: str(number) for number, test in enumerate(tests)}
        rows = [_OF_SUITE.join(test) for test in tests]
        for (module, where), of in sorted(self._by.items()):
            words = (at[of[n]] if n in of else _NOBODY for n in range(max(of) + 1))
            rows.append(f"{module}.{where}: {' '.join(_short(words))}")
        return rows

    @classmethod
    def read(cls, figures: dict[str, Any]) -> Killers:
        """From the figures of a run; empty when they have none."""
        found = cls()
        rows: Sequence[str] = figures.get("killers", ())
        tests: list[Name] = []
        for row in rows:
            of, _, words = row.partition(": ")
            if not words:
                suite, _, test = row.partition(_OF_SUITE)
                tests.append((suite, test))
                continue
            module, _, where = of.partition(".")
            for number, word in enumerate(_long(words)):
                found.add(module, where, number, None if word == _NOBODY else tests[int(word)])
        return found


def _short(words: Iterable[str]) -> list[str]:
    found = []
    for word, same in groupby(words):
        times = sum(1 for _ in same)
        found.append(word if times == 1 else f"{word}{_TIMES}{times}")
    return found


def _long(words: str) -> list[str]:
    found = []
    for word in words.split():
        one, _, times = word.partition(_TIMES)
        found += [one] * int(times or 1)
    return found
