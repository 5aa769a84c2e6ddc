"""Which interpreter proves a part, and what comes of one that fails."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from gazeprove import faster
from gazeprove.parts import PARTS
from gazesetup import NotAvailable, source_environment


def pretend(path: Path, does: str) -> Path:
    """An interpreter: called as PYPY -m gazeprove.faster PART ANSWER."""
    path.write_text(f"#!/bin/sh\n{does}\n")
    path.chmod(0o755)
    return path


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in PARTS:
        monkeypatch.setitem(PARTS, name, lambda quick, note: ({"quick": quick}, []))
    faster._pypy.cache_clear()


@pytest.mark.usefixtures("parts")
def test_a_long_part_runs_in_pypy(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    answer = json.dumps([{"states": 3}, ["one broken"]])
    pypy = pretend(tmp_path / "pypy3", f'echo \'{answer}\' > "$4"; test "$3" = fuzz')
    monkeypatch.setattr(faster, "ensure_pypy", lambda: pypy)
    assert faster.run("fuzz", False, print) == (
        {"states": 3, "interpreter": "PyPy"},
        ["one broken"],
    )
    assert faster.run("fuzz", True, print) == ({"quick": True}, [])
    assert faster.run("mutation", False, print) == ({"quick": False}, [])


@pytest.mark.usefixtures("parts")
@pytest.mark.parametrize("does", ["exit 3", "true", "echo '[{}, []]' > \"$4\"; exit 1"])
def test_a_pypy_that_fails_proves_nothing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, does: str
) -> None:
    monkeypatch.setattr(faster, "ensure_pypy", lambda: pretend(tmp_path / "pypy3", does))
    figures, short = faster.run("enumeration", False, print)
    assert figures == {}
    assert len(short) == 1


@pytest.mark.usefixtures("parts")
def test_without_pypy_the_part_runs_here(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def none() -> Path:
        raise NotAvailable("no archive")

    monkeypatch.setattr(faster, "ensure_pypy", none)
    assert faster.run("decisions", False, print) == ({"quick": False}, [])
    assert "no archive" in capsys.readouterr().out


def test_pypy_needs_nothing_but_the_sources() -> None:
    """It has none of the packages that are installed here."""
    words = [sys.executable, "-S", "-c", "from gazeprove import faster"]
    done = subprocess.run(words, env=source_environment(), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
