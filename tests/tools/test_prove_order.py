"""What the record says of the last run is tried first, and proves nothing by itself."""

from __future__ import annotations

from pathlib import Path

import pytest

from gazeprove import fuzz_mutants, kill, modules, mutate, part_fuzz, record_file, run_tests
from gazeprove.fuzz_mutants import PLANTED
from gazeprove.killers import Killers
from gazeprove.statements import Mark

SUITE = "board_core_pace"
PASSES = (SUITE, "test_before_the_first_tick_it_is_in_time")
FAILS = (SUITE, "test_every_edge_is_as_the_rule_says")
GONE = (SUITE, "test_that_was_renamed")
MUTANT = ("step", "return owed_us // _TICK_US  ->  return None")
_LINE = "if elapsed_us < 0 or elapsed_us {} _LONG_US:"
HARMLESS = ("step", f"{_LINE.format('>')}  ->  {_LINE.format('>=')}")


@pytest.fixture
def mutants() -> dict[tuple[str, str], mutate.Mutant]:
    return {mutant.key: mutant for mutant in mutate.mutants(modules.source_of("tick_clock"))}


@pytest.fixture
def killer() -> kill.Killer:
    ran = run_tests.Ran()
    for test, took_s in ((PASSES, 0.01), (FAILS, 0.05)):
        ran.seconds[test] = took_s
        ran.by_test[test] = {Mark("tick_clock", line, "") for line in range(1, 99)}
    return kill.Killer(ran)


@pytest.mark.parametrize("first", [None, FAILS, PASSES, GONE])
def test_a_mutant_is_killed_by_a_test_that_fails_now(
    killer: kill.Killer, mutants: dict[tuple[str, str], mutate.Mutant], first: run_tests.Name | None
) -> None:
    assert killer.killed_by("tick_clock", mutants[MUTANT], first=first) == FAILS
    assert killer.killed_by("tick_clock", mutants[HARMLESS], first=first) is None
    del killer.ran.by_test[FAILS], killer.ran.seconds[FAILS]
    weaker = kill.Killer(killer.ran)
    assert weaker.killed_by("tick_clock", mutants[MUTANT], first=first) is None


def test_the_first_one_is_tried_alone(
    killer: kill.Killer,
    mutants: dict[tuple[str, str], mutate.Mutant],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried: list[run_tests.Name] = []
    monkeypatch.setattr(killer, "_killer", lambda put_in, tests: tried.extend(tests) or tests[0])
    killer.killed_by("tick_clock", mutants[MUTANT], first=FAILS)
    assert tried == [FAILS, PASSES]


def test_mutants_are_numbered_in_their_function_whichever_are_made() -> None:
    source = modules.source_of("tick_clock")
    numbers = {mutant.key: mutant.number for mutant in mutate.mutants(source)}
    for where in {where for where, _ in numbers}:
        of = [number for (function, _), number in numbers.items() if function == where]
        assert of == list(range(len(of)))
    assert {m.key: m.number for m in mutate.mutants(source, 7, 3)}.items() <= numbers.items()


def test_the_record_keeps_who_killed(mutants: dict[tuple[str, str], mutate.Mutant]) -> None:
    killers = Killers()
    by = [FAILS, FAILS, None, PASSES, None, None, FAILS]
    for number, test in enumerate(by):
        killers.add("tick_clock", "step", number, test)
    killers.add("pid", "update", 1, GONE)
    rows = killers.rows()
    assert rows[-1] == "tick_clock.step: 1*2 - 0 -*2 1"
    kept = Killers.read({"killers": rows})
    assert kept.rows() == rows
    step = [m for m in mutants.values() if m.where == "step"]
    assert [kept.of("tick_clock", mutant) for mutant in step[: len(by)]] == by
    assert kept.of("zone", step[0]) is None
    assert Killers.read({}).rows() == []


@pytest.mark.parametrize(
    ("known", "broken", "lives", "begins"),
    [
        (0, {3}, 3, [1]),
        (3, {3, 5}, 3, [3]),
        (4, {3}, 3, [4, 1]),  # not broken any more: all lives, from the first on
        (4, set(), 0, [4, 1]),
    ],
)
def test_a_planted_mistake_is_looked_for_in_every_life_if_the_known_one_is_well(
    monkeypatch: pytest.MonkeyPatch, known: int, broken: set[int], lives: int, begins: list[int]
) -> None:
    begun = []

    def fuzz(only: str, env: dict[str, str], first: int, ticks: int) -> tuple[str, int]:
        begun.append(first)
        last = first if ticks == 1 else 9
        return "said", min((life for life in broken if first <= life <= last), default=0)

    monkeypatch.setattr(fuzz_mutants, "_fuzz", fuzz)
    assert fuzz_mutants.find(PLANTED[0], 600_000, 1, known).life == lives
    assert begun == begins


def test_a_mistake_that_no_life_shows_falls_short(monkeypatch: pytest.MonkeyPatch) -> None:
    """The record knows a life for each; one of them breaks no promise now."""
    lives_known = [(planted.name, 2) for planted in PLANTED]
    monkeypatch.setattr(record_file, "figures", lambda part: {"lives": lives_known})
    monkeypatch.setattr(
        fuzz_mutants, "_fuzz", lambda only, env, first, ticks: ("said", 0 if only else first)
    )
    figures, short = part_fuzz.planted_mistakes(False, lambda text: None)
    seldom = [planted.name for planted in PLANTED if planted.only]
    assert figures["found"] == len(PLANTED) - len(seldom)
    assert [text.partition(":")[0] for text in short] == seldom
    assert dict(figures["lives"]).keys() == {p.name for p in PLANTED} - set(seldom)


def test_a_fuzzer_that_fails_has_found_nothing(tmp_path: Path) -> None:
    """Only a life that broke a promise counts, not a Python that ends with 1."""
    (tmp_path / "gazeprove.py").write_text("")
    output, life = fuzz_mutants._fuzz("", {"PYTHONPATH": str(tmp_path)}, 1, 1)
    assert life == 0, output
