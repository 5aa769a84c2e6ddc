"""The quick form of tools/prove: a sample of each part of the proof holds."""

import subprocess
import sys

import pytest

import gazesetup
from gazeprove import mutate
from gazeprove.inputs import Choices

LIMIT_S = 600


@pytest.mark.parametrize(
    "part",
    [
        "enumeration",
        "everything at once",
        "decisions",
        "coverage",
        "mutation",
        "fuzz",
        "planted",
    ],
)
def test_the_quick_proof_holds(part: str) -> None:
    """Nothing falls short in this part."""
    done = subprocess.run(
        [sys.executable, "-m", "gazeprove", "--quick", "--part", part],
        cwd=gazesetup.ROOT,
        env=gazesetup.source_environment(),
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "PROVED" in done.stdout


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
