"""What is flashed calls without looking methods up, and is otherwise what was written."""

from __future__ import annotations

import ast
import random
import shutil
from pathlib import Path
from typing import Any

import pytest

import gazesetup
from gazechair.service.flash import calls, tree
from onmicropython import TESTS, assert_passes

SOURCE = """\
from gazelink.native import micropython

@micropython.native
def older(age_ms):
    # One tick later.
    return age_ms + 1 if age_ms < 300 else age_ms

class Ages:
    @micropython.native
    def step(self, i):
        self.age = older(self.age)
        self.twice = older(older(i))  # both
        self.most = max(self.age, min(i, 9))
        self.size = abs(-self._less(i,
            2)) + self._half()

    @micropython.native
    def _less(self, a, b):
        return a - b

    def _half(self):
        return self.age // 2
"""


def shorten(text: str) -> str:
    """One module's text, shortened."""
    return calls.shorten({"gazeboard/ages.py": text})["gazeboard/ages.py"]


def run(text: str) -> dict[str, Any]:
    """What a module's text defines."""
    names: dict[str, Any] = {}
    exec(compile(text, "ages.py", "exec"), names)
    return names


def test_the_short_form_does_the_same_on_the_same_lines() -> None:
    """Equal results on random numbers; no call of a known function is left; lines are kept."""
    short = shorten(SOURCE)
    for gone in ("older(self", "older(i", "min(", "self._less(", "self._half("):
        assert gone not in short
    lines = short.split("\n")
    for at, line in enumerate(SOURCE.split("\n")):
        if line.lstrip().startswith(("def ", "class ", "self.")):
            assert lines[at].startswith(line.split("=")[0].rstrip()), at
    rng = random.Random(5)
    chairs = [run(text)["Ages"]() for text in (SOURCE, short)]
    for chair in chairs:
        chair.age = 0
    for _ in range(1000):
        i = rng.randint(-400, 400)
        for chair in chairs:
            chair.step(i)
        assert chairs[0].__dict__ == chairs[1].__dict__


def test_the_names_of_methods_take_the_place_of_the_first_comment() -> None:
    """A module finds the names that it has first in fewer steps."""
    short = shorten("# Ages.\n" + SOURCE)
    assert short.startswith("_Ages_half = _Ages_less = None\nfrom gazelink.native")
    assert run(short)["_Ages_less"] is not None
    assert shorten(SOURCE).startswith("from gazelink.native")


@pytest.mark.parametrize(
    "text",
    [
        # inherited: which method it is depends on the object
        SOURCE + "\nclass More(Ages):\n    pass\n",
        # replaced on the object
        SOURCE + "\ndef f(ages):\n    ages._less = ages._half = None\n",
    ],
)
def test_methods_that_may_be_others_are_looked_up(text: str) -> None:
    """Only what can't be another method is called without looking."""
    short = shorten(text)
    assert "self._less(" in short
    assert "self._half(" in short


@pytest.mark.parametrize(
    "line",
    [
        "min(f(), 3)",  # worked out twice
        "older(next(i))",
        "min(i)",
        "min(*i)",
        "older(age_ms=i)",
        "double(f(), g())",  # in another order
    ],
)
def test_what_would_change_the_meaning_is_left(line: str) -> None:
    """Calls within are made once and in their order."""
    text = SOURCE + f"\n@micropython.native\ndef g(i, f):\n    x = 1\n    return {line}\n"
    text += "\n@micropython.native\ndef double(a, b):\n    return b * 2 + a\n"
    assert line in shorten(text)


def test_service_code_is_left() -> None:
    """The tick interrupts it between two looks at the same attribute."""
    text = SOURCE + "\nclass Slow:\n    def f(self, i):\n        return min(i.a, self._g(1))\n"
    assert shorten(text).split("class Slow")[1].startswith(text.split("class Slow")[1][:-1])


def test_a_name_that_means_something_else_is_left() -> None:
    """A function of the module's own called min."""
    text = SOURCE.replace("class Ages", "def min(a, b):\n    return 0\n\nclass Ages")
    assert "min(i, 9)" in shorten(text)


def test_the_firmware_keeps_its_lines_and_its_methods() -> None:
    """A line in a traceback is a line of the source; what the tick calls has become short."""
    sources = tree.find_sources()
    texts = sources.texts()
    for path, file in sources.files.items():
        was = file.read_text().splitlines()
        now = texts[path].splitlines()[: len(was)]
        assert len(now) == len(was)
        for line in ast.walk(ast.parse(file.read_text())):
            if isinstance(line, (ast.FunctionDef, ast.ClassDef)):
                assert now[line.lineno - 1] == was[line.lineno - 1]
    assert "_Safety_judge_command(self, i, " in texts["gazeboard/core/safety.py"]
    assert "wrapped(" in sources.files["gazeboard/core/motion.py"].read_text()
    assert "wrapped(" not in texts["gazeboard/core/motion.py"]


# The longest run on the same MicroPython as they are written; as flashed when this file is named.
LONG = ("board_promises_tilt", "board_promises_hardware")
ALWAYS = ("board_core_press", "board_promises_obstacles", "board_allocation")


def marks(file: Path) -> list[pytest.MarkDecorator]:
    """`tools/prove` runs and records those that `tools/test` does not."""
    if file.stem in LONG:
        return [pytest.mark.long]
    return [] if file.stem in ALWAYS else [pytest.mark.recorded]


FILES = [
    pytest.param(file, marks=marks(file), id=file.stem)
    for file in sorted(TESTS.glob("firmware/board_*.py"))
]


@pytest.fixture(scope="module")
def flashed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The firmware as it is flashed, with what only a PC has beside it."""
    folder = tmp_path_factory.mktemp("flashed")
    for package in (gazesetup.ROOT / "protocol/gazelink", gazesetup.ROOT / "firmware/gazeboard"):
        shutil.copytree(package, folder / package.name)
    for path, text in tree.find_sources().texts().items():
        (folder / path).write_text(text)
    return folder


@pytest.mark.parametrize("file", FILES)
def test_what_is_flashed_passes_the_firmwares_tests(
    file: Path, flashed: Path, micropython: gazesetup.MicroPython
) -> None:
    """All of them, on MicroPython, with the texts as they are flashed."""
    assert_passes(file, micropython, flashed)
