"""The parts of the proof: each prints its progress and returns its figures and what fell short."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from gazeprove import cover, decisions, equivalent, kill, mutate
from gazeprove.explore import explore
from gazeprove.inputs import CAUSES, Scope
from gazeprove.invariants import INVARIANTS
from gazeprove.scopes import scopes
from gazeprove.walk import Walk

MODULES = ("safety", "motion", "obstacles", "speed", "stopping", "bypass")
_NOTE_EVERY_S = 5.0
_QUICK_EVERY = 80  # the quick form tries one mutant in so many

Note = Callable[[str], None]
Part = tuple[dict[str, Any], list[str]]


def enumeration(quick: bool, note: Note) -> Part:
    """Explore every scope; hold random runs of the concrete core against each."""
    figures = dict.fromkeys(("scopes", "states", "transitions", "random_ticks", "moving_ticks"), 0)
    short: list[str] = []
    ticks = 5_000 if quick else 30_000
    wanted = scopes(quick)
    for number, scope in enumerate(wanted):
        found = explore(scope, note)
        walked = Walk(scope, found, seed=number).run(ticks)
        figures["scopes"] += 1
        figures["states"] += len(found.states)
        figures["transitions"] += found.transitions
        figures["random_ticks"] += walked.ticks
        figures["moving_ticks"] += walked.moving
        short += [f"{scope.name}: {text}" for text in (*found.broken, *walked.broken)]
        note(
            f"{number + 1}/{len(wanted)} {scope.name}: {len(found.states)} states,"
            f" {found.transitions} transitions, {walked.ticks} random ticks, {found.seconds:.1f} s"
        )
    figures["invariants"] = len(INVARIANTS) + 1  # and: from everywhere back to driving
    if not figures["moving_ticks"]:
        short.append("the random runs never moved")
    return figures, short


def everything_at_once(quick: bool, note: Note) -> Part:
    """Random runs with all causes together, the invariants after every tick."""
    lives, ticks = (1, 30_000) if quick else (40, 50_000)
    figures = {"random_ticks": 0, "moving_ticks": 0}
    short: list[str] = []
    noted = time.monotonic()
    for seed in range(lives):
        scope = Scope("everything at once", frozenset(CAUSES), all_commands=seed % 2 == 0)
        walked = Walk(scope, None, seed).run(ticks)
        figures["random_ticks"] += walked.ticks
        figures["moving_ticks"] += walked.moving
        short += [f"life {seed}: {text}" for text in walked.broken]
        if time.monotonic() - noted > _NOTE_EVERY_S:
            noted = time.monotonic()
            note(f"{figures['random_ticks']} of {lives * ticks} ticks")
    return figures, short


def decisions_of_obstacles(quick: bool, note: Note) -> Part:
    """Every decision of the obstacle rule, from every level, at every distance that matters."""
    figures = {"settings": 0, "decisions": 0}
    short: list[str] = []
    for settings in decisions.settings_tried(quick):
        found = decisions.explore(settings, quick, note)
        figures["settings"] += 1
        figures["decisions"] += found.decisions
        short += found.broken
    return figures, short


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
    order = kill.timed_order()
    noted = time.monotonic()
    for module in MODULES:
        known = equivalent.reasons(module)
        gone = set(known)
        for mutant in mutate.mutants(kill.source_of(module), _QUICK_EVERY if quick else 1):
            figures["mutants"] += 1
            gone.discard(mutant.key)
            survives = kill.survives(module, mutant.code, order)
            listed = mutant.key in known
            figures["killed"] += not survives
            figures["equivalent"] += survives and listed
            figures["survived"] += survives and not listed
            where = f"{module}.py:{mutant.line} {mutant.where}: {mutant.change}"
            if survives and not listed:
                short.append(f"survived: {where}")
            if listed and not survives:
                short.append(f"listed as equivalent, but killed: {where}")
            if time.monotonic() - noted > _NOTE_EVERY_S:
                noted = time.monotonic()
                note(f"{module}: {figures['mutants']} mutants, {figures['survived']} survived")
        if not quick:
            short += [f"{module}: listed, but there is no such mutant: {key}" for key in gone]
    return figures, short


PARTS: dict[str, Callable[[bool, Note], Part]] = {
    "enumeration": enumeration,
    "everything at once": everything_at_once,
    "decisions": decisions_of_obstacles,
    "coverage": coverage,
    "mutation": mutation,
}
