"""docs/extending.md does what it says: its modules, copied verbatim, drive the chair."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import gazesetup
from gazechair.config import configuration

LIMIT_S = 240.0
TEXT = (gazesetup.ROOT / "docs" / "extending.md").read_text("utf-8")
BLOCKS = re.findall(r"^```(\w+) file=(\S+)\n(.*?)^```$", TEXT, re.DOTALL | re.MULTILINE)
KINDS = {"words": "input", "ahead": "mode"}
pytestmark = pytest.mark.xdist_group("wheel")


def block(name: str) -> str:
    return "".join(text for _, file, text in BLOCKS if file == name)


@pytest.fixture(scope="module")
def environment(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """The wheel, and beside it what the page's commands make of its blocks."""
    folder = tmp_path_factory.mktemp("builder")
    added = folder / "site"
    path = f"{installed}{os.pathsep}{added}"
    env = {**os.environ, "PYTHONPATH": path, "XDG_CACHE_HOME": str(folder / "cache")}
    places = []
    for name, kind in KINDS.items():
        run(env, "-m", "gazechair", "plugin", "new", name, "--kind", kind, "--folder", str(folder))
        place = folder / f"gazechair-{name}"
        module = place / f"gazechair_{name}.py"
        assert module.is_file()
        module.write_text(block(module.name), "utf-8")
        places.append(str(place))
    pip = ("-m", "pip", "install", "--no-deps", "--disable-pip-version-check")
    run(env, *pip, "--target", str(added), *places)
    return env


def run(env: dict[str, str], *words: str) -> str:
    done = subprocess.run(
        [sys.executable, *words], env=env, capture_output=True, text=True, timeout=LIMIT_S
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("name", KINDS)
def test_the_module_passes_the_check_and_drives_the_chair(
    name: str, environment: dict[str, str]
) -> None:
    output = run(environment, "-m", "gazechair", "plugin", "check", f"{KINDS[name]}.{name}")
    assert "ok    armed, it drives the chair: wipers after" in output
    assert "FAILS" not in output


def test_it_is_listed_beside_ours(environment: dict[str, str]) -> None:
    output = run(environment, "-m", "gazechair", "plugin", "list")
    for title in ("input.gamepad (gazechair)", "input.words (gazechair-words)", "mode.ahead ("):
        assert title in output
    assert "ModuleNotFoundError" not in output


def test_a_module_is_some_40_lines_and_the_configuration_is_one() -> None:
    for name in KINDS:
        lines = [line for line in block(f"gazechair_{name}.py").splitlines() if line.strip()]
        assert 15 < len(lines) <= 42
    plugins = configuration.parse(block("chair.toml")).plugins
    assert [plugin.title for plugin in plugins] == ["input.words", "mode.ahead"]


def test_every_intent_of_the_table_exists() -> None:
    import gazechair.plugins as ours

    names = re.findall(r"^\| `(\w+)", TEXT, re.MULTILINE)
    assert {"NOTHING", "STOP", "hold", "step", "drive", "choose"} == set(names)
    assert set(names) <= set(ours.__all__)
