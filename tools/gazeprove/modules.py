"""What the mutants are made of: the modules proven by their own tests, and those tests."""

from __future__ import annotations

from pathlib import Path

from gazesetup import ROOT

_FIRMWARE = ROOT / "firmware"
TESTS = ROOT / "tests" / "firmware"

# name -> as Python imports it
_CORE = (
    "tick",
    "safety",
    "auto",
    "directions",
    "ages",
    "motion",
    "obstacles",
    "arcs",
    "speed",
    "stopping",
    "bypass",
    "obedience",
    "profile_check",
    "zone",
    "tilt",
    "tick_clock",
)
_TURNING = ("pid", "slope", "small_moves", "stop_plan", "casters", "chair_model", "turn")
MODULES = {
    **{name: f"gazeboard.core.{name}" for name in _CORE},
    **{name: f"gazeboard.turning.{name}" for name in _TURNING},
}
# Tests that a mutant must not survive: each calls the modules themselves, none a whole board.
SUITES = (
    *sorted(path.stem for path in TESTS.glob("board_core_*.py")),
    "board_profile_check",
    "board_tick_clock",
    *sorted(path.stem for path in TESTS.glob("board_turning_*.py")),
    "test_tick_twins",
)


def file_of(module: str) -> Path:
    """Where a module of MODULES is."""
    return _FIRMWARE / (MODULES[module].replace(".", "/") + ".py")


def source_of(module: str) -> str:
    """Its text."""
    return file_of(module).read_text()


def suite_files() -> list[Path]:
    """The files of the suites."""
    return [TESTS / f"{suite}.py" for suite in SUITES]
