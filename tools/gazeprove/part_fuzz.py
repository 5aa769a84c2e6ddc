"""The parts that run the whole firmware: random lives, and mistakes that they must find."""

from __future__ import annotations

import os
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from gazelink import codes
from gazeprove import fuzz, fuzz_mutants, record_file
from gazeprove.pools import NOTE_EVERY_S, Note, Part

_FIRST_SEED = 1
_SHRUNK = 5  # broken lives that are shrunk and shown
_QUICK_PLANTED = 8  # the quick form plants one mistake in so many
_PLANTED_TICKS = 600_000
# What must have come about in all those lives for them to say anything.
_FUZZED = (
    "armings",
    "moving",
    "auto",
    *codes.VERBS[1:],
    *(f"P{number}" for number in (2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 13, 14, 16, 17, 18, 19, 20)),
)


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
        if time.monotonic() - noted > NOTE_EVERY_S:
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
    known = dict(record_file.figures("planted").get("lives", ()))
    lives: list[tuple[str, int]] = []
    short: list[str] = []

    def find(planted: fuzz_mutants.Planted) -> fuzz_mutants.Found:
        of = known.get(planted.name, 0)
        return fuzz_mutants.find(planted, _PLANTED_TICKS, _FIRST_SEED, of)

    with ThreadPoolExecutor(1 if quick else os.cpu_count()) as pool:
        for found in pool.map(find, chosen):
            note(str(found))
            if found.life:
                lives.append((found.name, found.life))
            else:
                short.append(str(found))
    return {"planted": len(chosen), "found": len(lives), "lives": lives}, short
