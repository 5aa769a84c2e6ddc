"""The parts that hold core and turning against their own tests: what these run and cannot tell."""

from __future__ import annotations

import time
from typing import Any

from gazeprove import equivalents, kill, mutate, record_file
from gazeprove.killers import Killers
from gazeprove.modules import MODULES, source_of
from gazeprove.pools import NOTE_EVERY_S, Note, Part, pool
from gazeprove.run_tests import Name, Ran, run_tests

_QUICK_EVERY = 160  # the quick form tries one mutant in so many
_SLICE = 32  # mutants that a process takes at a time

Listed = dict[tuple[str, str], str]  # mutants known to be equivalent, and why
# A mutant's key, its number in its function, its line, and the test that killed it.
Tried = tuple[tuple[str, str], int, int, Name | None]


def coverage(quick: bool, note: Note) -> Part:
    """Statements and branches of these modules that their own tests run."""
    ran = run_tests()
    run = ran.loading.union(*ran.by_test.values())
    figures: dict[str, Any] = {}
    for module in MODULES:
        places = {place for place in ran.places if place.module == module}
        figures[f"{module}_statements"] = sum(not place.way for place in places)
        figures[f"{module}_branches"] = sum(bool(place.way) for place in places)
    missing = sorted({place for place in ran.places if place not in run}, key=str)
    figures["missing"] = len(missing)
    note(", ".join(f"{name} {value}" for name, value in figures.items()))
    return figures, [f"{place} is not run by their own tests" for place in missing]


def mutation(quick: bool, note: Note) -> Part:
    """Mutants of these modules against their own tests; the quick form tries a sample of them."""
    figures: dict[str, Any] = dict.fromkeys(("mutants", "killed", "equivalent", "survived"), 0)
    short: list[str] = []
    listed_of = {module: equivalents.reasons(module) for module in MODULES}
    for module in MODULES:
        gone = set(listed_of[module]) - mutate.keys(source_of(module))
        short += [f"{module}: listed, but there is no such mutant: {key}" for key in sorted(gone)]
    made = {
        module: list(mutate.mutants(source_of(module), _QUICK_EVERY if quick else 1))
        for module in MODULES
    }
    slices = [(m, first) for m in MODULES for first in range(0, len(made[m]), _SLICE)]
    before, killers = Killers.read(record_file.figures("mutation")), Killers()
    noted = time.monotonic()
    with pool(quick, _begin, (run_tests(), made, listed_of, before)) as processes:
        checked = list(MODULES)[:1] if quick else list(MODULES)
        for module, survives in zip(checked, processes.map(_unchanged, checked), strict=True):
            if not survives:
                short.append(f"{module}: killed without a change: the prover is wrong")
        for module, tried in processes.imap_unordered(_kill_slice, slices):
            known = listed_of[module]
            for (where, change), number, line, by in tried:
                killers.add(module, where, number, by)
                listed, survives = (where, change) in known, by is None
                figures["mutants"] += 1
                figures["killed"] += not survives
                figures["equivalent"] += survives and listed
                figures["survived"] += survives and not listed
                if survives != listed:
                    wrong = "survived" if survives else "listed as equivalent, but killed"
                    short.append(f"{wrong}: {module}.py:{line} {where}: {change}")
                    note(short[-1])
            if time.monotonic() - noted > NOTE_EVERY_S:
                noted = time.monotonic()
                note(f"{module}: {figures['mutants']} mutants, {figures['survived']} survived")
    return {**figures, "killers": killers.rows()}, short


# In each process of the pool: it learns which tests kill.
_killer: kill.Killer
_made: dict[str, list[mutate.Mutant]]
_listed: dict[str, Listed]
_before: Killers


def _begin(
    ran: Ran, made: dict[str, list[mutate.Mutant]], listed: dict[str, Listed], before: Killers
) -> None:
    global _killer, _made, _listed, _before
    _killer, _made, _listed, _before = kill.Killer(ran), made, listed, before


def _unchanged(module: str) -> bool:
    """Whether what is no mutant survives: put in as the others are, but not changed."""
    return _killer.survives(module, mutate.unchanged(source_of(module)), listed=True)


def _kill_slice(of: tuple[str, int]) -> tuple[str, list[Tried]]:
    """Some mutants of a module, and what killed each."""
    module, first = of
    known = _listed[module]
    tried = []
    for m in _made[module][first : first + _SLICE]:
        by = _killer.killed_by(module, m, m.key in known, _before.of(module, m))
        tried.append((m.key, m.number, m.line, by))
    return module, tried
