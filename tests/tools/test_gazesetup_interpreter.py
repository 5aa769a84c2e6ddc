"""Which Python the virtual environment is made of."""

import sys
from pathlib import Path

import pytest

from gazesetup import interpreter

ANSWER = '["3.11.99 (main)", "/somewhere"]'


@pytest.fixture(autouse=True)
def own_build(monkeypatch: pytest.MonkeyPatch) -> None:
    """The running Python was compiled by somebody, without optimisation."""
    monkeypatch.setattr(interpreter, "optimised", lambda: False)
    monkeypatch.setattr(sys, "base_prefix", "/home/somebody/python")


def distribution(folder: Path, script: str) -> Path:
    """A /usr whose Python of the running version is this shell script."""
    python = folder / f"bin/python{sys.version_info[0]}.{sys.version_info[1]}"
    python.parent.mkdir()
    python.write_text(f"#!/bin/sh\n{script}\n")
    python.chmod(0o755)
    return folder


def test_the_distributions_build_is_preferred_to_ones_own(tmp_path: Path) -> None:
    """Of the same version."""
    usr = distribution(tmp_path, f"echo '{ANSWER}'")
    found = interpreter.best(usr)
    assert Path(found.path).parent == usr / "bin"
    assert (found.version, found.prefix) == ("3.11.99 (main)", "/somewhere")


@pytest.mark.parametrize("script", ["exit 1", "echo no ensurepip", "echo '[1]'", "echo 7"])
def test_one_that_cannot_make_an_environment_is_left_alone(tmp_path: Path, script: str) -> None:
    """Debian has ensurepip in a package of its own."""
    assert interpreter.best(distribution(tmp_path, script)).version == sys.version


def test_without_one_the_running_python_does(tmp_path: Path) -> None:
    """As on a machine with another version only."""
    assert interpreter.best(tmp_path).version == sys.version


def test_an_optimised_build_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As most are."""
    monkeypatch.setattr(interpreter, "optimised", lambda: True)
    usr = distribution(tmp_path, f"echo '{ANSWER}'")
    assert interpreter.best(usr).version == sys.version


def test_the_distributions_own_python_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also when it runs in the environment that was made of it: the same answer again."""
    usr = distribution(tmp_path, f"echo '{ANSWER}'")
    monkeypatch.setattr(sys, "base_prefix", str(usr))
    assert interpreter.best(usr).version == sys.version
