"""The quick form of tools/prove: a sample of each part of the proof holds."""

import subprocess
import sys

import pytest

import gazesetup
from gazeprove import (
    equivalents,
    kill,
    modules,
    mutate,
    part_costly,
    part_long,
    run_tests,
    statements,
)
from gazeprove.inputs import Choices
from gazeprove.parts import PARTS as ALL

LIMIT_S = 600


PARTS = (("enumeration", "everything at once", "decisions"), ("fuzz",))
# Of these a sample takes as long as all other tests of the prover: what the record says counts.
RECORDED = ("coverage", "mutation", "planted", *part_long.begins(), part_costly.NAME)


@pytest.mark.costly
@pytest.mark.parametrize("parts", PARTS, ids=lambda parts: parts[0])
def test_the_quick_proof_holds(parts: tuple[str, ...]) -> None:
    """Nothing falls short in these parts."""
    chosen = [word for part in parts for word in ("--part", part)]
    done = subprocess.run(
        [sys.executable, "-m", "gazeprove", "--quick", *chosen],
        cwd=gazesetup.ROOT,
        env=gazesetup.source_environment(),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "PROVED" in done.stdout


def test_no_part_is_left_out() -> None:
    """What the proof consists of is tried in its quick form, or recorded."""
    assert sorted([*(part for parts in PARTS for part in parts), *RECORDED]) == sorted(ALL)


def test_a_mutant_that_no_test_runs_survives_and_one_that_fails_a_test_does_not() -> None:
    """Both ways to put a mutant in: a function's code, and the whole module."""
    ran = run_tests.Ran()
    tests = [("board_core_pace", "test_before_the_first_tick_it_is_in_time")]
    tests.append(("board_core_pace", "test_every_edge_is_as_the_rule_says"))
    for test in tests:
        ran.seconds[test] = 0.05
        ran.by_test[test] = {statements.Mark("tick_clock", line, "") for line in range(1, 99)}
    killer = kill.Killer(ran)
    source = modules.source_of("tick_clock")
    assert killer.survives("tick_clock", mutate.unchanged(source))
    found = {mutant.key: mutant for mutant in mutate.mutants(source)}
    for where, change, survives in (
        ("step", "return owed_us // _TICK_US  ->  return None", False),
        ("__init__", "self.late = False  ->  self.late = True", False),
        ("module", "_TICK_US = 1000  ->  _TICK_US = 1001", False),
        ("module", "_LONG_US = 1000000  ->  pass", False),
    ):
        assert killer.survives("tick_clock", found[where, change]) is survives, change
    ran.by_test.clear()
    ran.seconds.clear()
    nobody = kill.Killer(ran)
    change = "self.late = False  ->  self.late = True"
    assert nobody.survives("tick_clock", found["__init__", change])


def test_what_is_listed_has_a_reason_and_may_stand_for_every_change_of_a_line() -> None:
    """Each listed mutant exists, and "*" is spelled out."""
    for module in modules.MODULES:
        listed = equivalents.reasons(module)
        assert all(listed.values())
        assert not set(listed) - mutate.keys(modules.source_of(module))
        assert not any(change.endswith("*") for _, change in listed)


def test_choices_visit_every_leaf_of_an_uneven_tree() -> None:
    """A choice that only comes after another one is not lost."""
    choices = Choices()
    leaves = []
    while True:
        first = choices.pick(3)
        leaves.append((first, choices.pick(2) if first == 1 else None))
        if not choices.following():
            break
    assert leaves == [(0, None), (1, 0), (1, 1), (2, None)]


def test_mutants_are_one_change_each_and_leave_the_source_alone() -> None:
    """Every mutant compiles, differs, and the next one starts from the source again."""
    source = "def f(a):\n    if a > 1 and a < 9:\n        return a + 1\n    return False\n"
    made = list(mutate.mutants(source))
    changes = {mutant.change for mutant in made}
    assert len(changes) == len(made) > 10
    assert "return a + 1  ->  return a - 1" in changes
    assert "if a > 1 and a < 9:  ->  if a >= 1 and a < 9:" in changes
    assert "if a > 1 and a < 9:  ->  if a > 1 or a < 9:" in changes
    assert "return False  ->  return True" in changes
