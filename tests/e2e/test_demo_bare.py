"""`tools/demo` on a fresh machine: nothing is installed but what it installs itself."""

from __future__ import annotations

import contextlib
import subprocess
import urllib.request
import venv
from importlib import metadata
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement

import gazesetup
from e2e.demo_family import RUNNING, Family

pytestmark = pytest.mark.e2e

EXTRA = "sim"  # as tools/demo asks for


def python(folder: Path, extra: str) -> Path:
    """A Python beside which is found what `pip install gazechair[extra]` installs, no more."""
    venv.create(folder, symlinks=True)
    (packages,) = folder.glob("lib/python*/site-packages")
    for name in needed(extra):
        one = metadata.distribution(name)
        for top in {path.parts[0] for path in one.files or () if path.parts[0] != ".."}:
            with contextlib.suppress(FileExistsError):
                (packages / top).symlink_to(Path(str(one.locate_file(top))))
    with contextlib.suppress(FileExistsError):
        (packages / "gazeweb").symlink_to(gazesetup.ROOT / "web")  # as an editable installation
    return folder / "bin" / "python"


def needed(extra: str) -> set[str]:
    """Its distributions."""
    found: set[str] = set()
    waiting = [("gazechair", extra)]
    while waiting:
        name, extra = waiting.pop()
        for line in metadata.requires(name) or []:
            one = Requirement(line)
            inside = {**default_environment(), "extra": extra}
            if (one.marker is None or one.marker.evaluate(inside)) and one.name not in found:
                found.add(one.name)
                waiting += [(one.name, more) for more in one.extras or [""]]
    return found - {"gazechair"}  # what it is itself, the environment of the sources shows


@pytest.fixture(scope="module")
def bare_python(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """As tools/demo makes it."""
    return python(tmp_path_factory.mktemp("bare"), EXTRA)


def test_what_tests_need_is_not_there(bare_python: Path) -> None:
    for name in ("playwright", "apprise", "g2opy", "pytest"):
        done = subprocess.run([bare_python, "-c", f"import {name}"], capture_output=True, text=True)
        assert "ModuleNotFoundError" in done.stderr, name


def test_an_installation_without_the_extra_says_what_to_install(tmp_path: Path) -> None:
    plain = python(tmp_path, "")
    for options in ((), ("--check",)):
        done = subprocess.run(
            [plain, "-m", "gazechair", "demo", *options],
            env=gazesetup.source_environment(),
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert done.returncode == 2
        assert "pip install 'gazechair[sim]'" in done.stderr
        assert "Traceback" not in done.stderr


@pytest.mark.parametrize("where", [(), ("--home",)], ids=["living", "home"])
def test_it_shows_a_page(
    bare_python: Path, tmp_path_factory: pytest.TempPathFactory, where: tuple[str, ...]
) -> None:
    command = str(bare_python), "-m", "gazedemo", *where
    family = Family(tmp_path_factory.mktemp("d"), command, **gazesetup.source_environment())
    try:
        page = family.until(RUNNING).split()[-1]
        with urllib.request.urlopen(page, timeout=20) as answer:
            assert b"<html" in answer.read()
    finally:
        family.end()
