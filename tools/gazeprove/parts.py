"""The parts of the proof: each prints its progress and returns its figures and what fell short."""

from __future__ import annotations

import multiprocessing.pool
import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from gazelink import codes
from gazeprove import cover, decisions, equivalent, fuzz, fuzz_mutants, kill, mutate
from gazeprove.explore import explore
from gazeprove.inputs import CAUSES, Scope
from gazeprove.invariants import INVARIANTS
from gazeprove.scopes import scopes
from gazeprove.walk import Walk

MODULES = ("safety", "ages", "motion", "obstacles", "speed", "stopping", "bypass", "obedience")
_NOTE_EVERY_S = 5.0
_QUICK_EVERY = 80  # the quick form tries one mutant in so many
_SLICES = 40  # of each module's mutants: what a process takes at a time
_FIRST_SEED = 1
_SHRUNK = 5  # broken lives that are shrunk and shown
_QUICK_PLANTED = 8  # the quick form plants one mistake in so many
_PLANTED_TICKS = 600_000
# What must have come about in all those lives for them to say anything.
_FUZZED = (
    "armings",
    "moving",
    *codes.VERBS[1:],
    *(f"P{number}" for number in (2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 16)),
)

Note = Callable[[str], None]
Part = tuple[dict[str, Any], list[str]]


def _pool(quick: bool, *setup: Any) -> multiprocessing.pool.Pool:
    """A process for each core; in the quick form one, because the tests have those cores."""
    return multiprocessing.get_context("fork").Pool(1 if quick else None, *setup)


def enumeration(quick: bool, note: Note) -> Part:
    """Explore every scope; hold random runs of the concrete core against each."""
    figures = dict.fromkeys(("scopes", "states", "transitions", "random_ticks", "moving_ticks"), 0)
    short: list[str] = []
    ticks = 5_000 if quick else 30_000
    wanted = [(scope, number, ticks) for number, scope in enumerate(scopes(quick))]
    with _pool(quick) as pool:
        for name, counted, broken in pool.imap_unordered(_explore, wanted):
            for figure, count in counted.items():
                figures[figure] += count
            short += broken
            counts = ", ".join(f"{figure} {count}" for figure, count in counted.items())
            note(f"{figures['scopes']}/{len(wanted)} {name}: {counts}")
    figures["invariants"] = len(INVARIANTS) + 1  # and: from everywhere back to driving
    if not figures["moving_ticks"]:
        short.append("the random runs never moved")
    return figures, short


def _explore(of: tuple[Scope, int, int]) -> tuple[str, dict[str, int], list[str]]:
    """One scope: its name, its figures, what is broken."""
    scope, seed, ticks = of
    found = explore(scope)
    walked = Walk(scope, found, seed).run(ticks)
    counted = {
        "scopes": 1,
        "states": len(found.states),
        "transitions": found.transitions,
        "random_ticks": walked.ticks,
        "moving_ticks": walked.moving,
    }
    return scope.name, counted, [f"{scope.name}: {t}" for t in (*found.broken, *walked.broken)]


def everything_at_once(quick: bool, note: Note) -> Part:
    """Random runs with all causes together, the invariants after every tick."""
    lives, ticks = (1, 30_000) if quick else (40, 50_000)
    figures = {"random_ticks": 0, "moving_ticks": 0}
    short: list[str] = []
    noted = time.monotonic()
    with _pool(quick) as pool:
        for ran, moving, broken in pool.imap_unordered(_walk, [(n, ticks) for n in range(lives)]):
            figures["random_ticks"] += ran
            figures["moving_ticks"] += moving
            short += broken
            if time.monotonic() - noted > _NOTE_EVERY_S:
                noted = time.monotonic()
                note(f"{figures['random_ticks']} of {lives * ticks} ticks")
    return figures, short


def _walk(of: tuple[int, int]) -> tuple[int, int, list[str]]:
    """One random run: ticks, those that moved, what is broken."""
    seed, ticks = of
    scope = Scope("everything at once", frozenset(CAUSES), all_commands=seed % 2 == 0)
    walked = Walk(scope, None, seed).run(ticks)
    return walked.ticks, walked.moving, [f"life {seed}: {text}" for text in walked.broken]


def decisions_of_obstacles(quick: bool, note: Note) -> Part:
    """Every decision of the obstacle rule, from every level, at every distance that matters."""
    figures = {"settings": 0, "decisions": 0}
    short: list[str] = []
    tried = list(decisions.settings_tried(quick))
    with _pool(quick) as pool:
        for counted, broken in pool.imap(_decide, [(n, quick) for n in range(len(tried))]):
            figures["settings"] += 1
            figures["decisions"] += counted
            short += broken
            note(
                f"{figures['settings']} of {len(tried)} settings, {figures['decisions']} decisions"
            )
    return figures, short


def _decide(of: tuple[int, bool]) -> tuple[int, list[str]]:
    """One of the settings: decisions, what is broken."""
    number, quick = of
    found = decisions.explore(list(decisions.settings_tried(quick))[number], quick)
    return found.decisions, found.broken


def coverage(quick: bool, note: Note) -> Part:
    """Lines and branches of the core that its own tests run."""
    figures: dict[str, Any] = {}
    short: list[str] = []
    for found in cover.measure(MODULES):
        figures[f"{found.module}_lines"] = found.lines
        figures[f"{found.module}_branches"] = found.branches
        short += [f"{found.module}: {what} is not run by its tests" for what in found.missing]
    figures["missing"] = len(short)
    note(", ".join(f"{name} {value}" for name, value in figures.items()))
    return figures, short


def mutation(quick: bool, note: Note) -> Part:
    """Mutants of the core against its own tests; the quick form tries a sample of them."""
    figures = dict.fromkeys(("mutants", "killed", "equivalent", "survived"), 0)
    short: list[str] = []
    for module in MODULES:
        gone = set(equivalent.reasons(module)) - mutate.keys(kill.source_of(module))
        short += [f"{module}: listed, but there is no such mutant: {key}" for key in sorted(gone)]
    every = _QUICK_EVERY if quick else _SLICES
    slices = [(m, every, first) for m in MODULES for first in range(1 if quick else every)]
    noted = time.monotonic()
    with _pool(quick, _begin_killing, (kill.known_tests(),)) as pool:
        for module, tried in pool.imap_unordered(_kill_slice, slices):
            known = equivalent.reasons(module)
            for mutant_key, line, survives in tried:
                listed = mutant_key in known
                figures["mutants"] += 1
                figures["killed"] += not survives
                figures["equivalent"] += survives and listed
                figures["survived"] += survives and not listed
                if survives != listed:
                    wrong = "survived" if survives else "listed as equivalent, but killed"
                    where, change = mutant_key
                    short.append(f"{wrong}: {module}.py:{line} {where}: {change}")
                    note(short[-1])
            if time.monotonic() - noted > _NOTE_EVERY_S:
                noted = time.monotonic()
                note(f"{module}: {figures['mutants']} mutants, {figures['survived']} survived")
    return figures, short


_known_tests: kill.Tests


def _begin_killing(tests: kill.Tests) -> None:
    """In each process of the pool: its own order of the tests, which it learns."""
    global _known_tests
    _known_tests = tests


def _kill_slice(
    of: tuple[str, int, int],
) -> tuple[str, list[tuple[tuple[str, str], int, bool]]]:
    """One in so many mutants of a module: (key, line, whether it survives) of each."""
    module, every, first = of
    known = equivalent.reasons(module)
    tried = []
    for mutant in mutate.mutants(kill.source_of(module), every, first):
        survives = kill.survives(module, mutant, _known_tests, mutant.key in known)
        tried.append((mutant.key, mutant.line, survives))
    return module, tried


def fuzzing(quick: bool, note: Note) -> Part:
    """The whole firmware in random lives, its outputs against the promises' text."""
    ticks, processes = (60_000, 1) if quick else (10_000_000, os.cpu_count() or 1)
    figures: dict[str, Any] = {"first_seed": _FIRST_SEED, "ticks": 0, "lives": 0, "broken": 0}
    causes: dict[str, int] = dict.fromkeys(_FUZZED, 0)
    short: list[str] = []
    noted = time.monotonic()
    for outcome in fuzz.fuzz(ticks, _FIRST_SEED, processes):
        figures["ticks"] += outcome.ticks
        figures["lives"] += 1
        for name in causes:
            causes[name] += outcome.stats.get(name, 0)
        if outcome.broken:
            figures["broken"] += 1
            if len(short) < _SHRUNK:
                short.append(str(fuzz.shrink(outcome)))
        if time.monotonic() - noted > _NOTE_EVERY_S:
            noted = time.monotonic()
            note(f"{figures['ticks']} of {ticks} ticks, {figures['broken']} lives broke a promise")
    if figures["broken"] > len(short):
        short.append(f"and {figures['broken'] - len(short)} lives more")
    short += [f"{name} never came about" for name in causes if not quick and not causes[name]]
    if not causes["moving"]:
        short.append("the chair never moved")
    return {**figures, **causes}, short


def planted_mistakes(quick: bool, note: Note) -> Part:
    """Mistakes planted in copies of the firmware, which the fuzzer must find."""
    chosen = fuzz_mutants.PLANTED[:: _QUICK_PLANTED if quick else 1]
    short: list[str] = []
    figures = {"planted": len(chosen), "found": 0}
    with ThreadPoolExecutor(1 if quick else os.cpu_count()) as pool:
        for found in pool.map(lambda p: fuzz_mutants.find(p, _PLANTED_TICKS, _FIRST_SEED), chosen):
            figures["found"] += found.found
            note(str(found))
            if not found.found:
                short.append(str(found))
    return figures, short


PARTS: dict[str, Callable[[bool, Note], Part]] = {
    "enumeration": enumeration,
    "everything at once": everything_at_once,
    "decisions": decisions_of_obstacles,
    "coverage": coverage,
    "mutation": mutation,
    "fuzz": fuzzing,
    "planted": planted_mistakes,
}
