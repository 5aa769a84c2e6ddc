"""The parts of the proof: each prints its progress and returns its figures and what fell short."""

from __future__ import annotations

from collections.abc import Callable

from gazeprove import part_core, part_costly, part_fuzz, part_long, part_tests
from gazeprove.pools import Note, Part

PARTS: dict[str, Callable[[bool, Note], Part]] = {
    "enumeration": part_core.enumeration,
    "everything at once": part_core.everything_at_once,
    "decisions": part_core.decisions_of_obstacles,
    "coverage": part_tests.coverage,
    "mutation": part_tests.mutation,
    "fuzz": part_fuzz.fuzzing,
    "planted": part_fuzz.planted_mistakes,
    "as flashed": part_long.as_flashed,
    "webassembly": part_long.webassembly,
    "emulated": part_long.emulated,
    "longest": part_long.longest,
    "promises": part_long.promises,
    part_costly.NAME: part_costly.costly,
}
