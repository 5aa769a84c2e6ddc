"""The parts that explore the core by itself: every state, random runs, the obstacle rule."""

from __future__ import annotations

import time
from typing import Any

from gazeprove import decisions
from gazeprove.explore import explore
from gazeprove.inputs import CAUSES, Scope
from gazeprove.invariants import INVARIANTS
from gazeprove.pools import NOTE_EVERY_S, Note, Part, pool
from gazeprove.scopes import scopes
from gazeprove.walk import Walk


def enumeration(quick: bool, note: Note) -> Part:
    """Explore every scope; hold random runs of the concrete core against each."""
    names = ("scopes", "states", "transitions", "ticks", "random_ticks", "moving_ticks")
    figures: dict[str, Any] = dict.fromkeys(names, 0)
    short: list[str] = []
    ticks = 5_000 if quick else 50_000
    wanted = [(scope, number, ticks) for number, scope in enumerate(scopes(quick))]
    with pool(quick) as processes:
        for name, counted, broken in processes.imap_unordered(_explore, wanted):
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
        "ticks": found.ticks,
        "random_ticks": walked.ticks,
        "moving_ticks": walked.moving,
    }
    broken = [f"{scope.name}: {text}" for text in (*found.broken, *walked.broken)]
    return scope.name, counted, broken


def everything_at_once(quick: bool, note: Note) -> Part:
    """Random runs with all causes together, the invariants after every tick."""
    lives, ticks = (1, 30_000) if quick else (40, 50_000)
    figures = {"random_ticks": 0, "moving_ticks": 0}
    short: list[str] = []
    noted = time.monotonic()
    with pool(quick) as processes:
        for ran, moving, broken in processes.imap_unordered(
            _walk, [(n, ticks) for n in range(lives)]
        ):
            figures["random_ticks"] += ran
            figures["moving_ticks"] += moving
            short += broken
            if time.monotonic() - noted > NOTE_EVERY_S:
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
    with pool(quick) as processes:
        for counted, broken in processes.imap(_decide, [(n, quick) for n in range(len(tried))]):
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
