"""Which MicroPython the set-up chooses, and what it says when there is none."""

from pathlib import Path

import pytest

import gazesetup
from gazesetup import apt
from gazesetup import micropython as finder

SAYS = '#!/bin/sh\necho "{}"\n'


def program(path: Path, text: str) -> Path:
    """An executable shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)
    return path


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine with no MicroPython, no Debian archive, nothing cached."""
    monkeypatch.delenv("GAZECHAIR_MICROPYTHON", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr(apt, "debian_archives", list)
    return tmp_path


def test_the_given_one_is_taken_when_it_runs(bare: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Checked by running it."""
    path = program(bare / "mine", SAYS.format("micropython 1.27.0 32"))
    monkeypatch.setenv("GAZECHAIR_MICROPYTHON", str(path))
    found = finder.ensure_micropython(local=bare)
    assert found.path == path
    assert found.description == "MicroPython 1.27.0, 32-bit, given by GAZECHAIR_MICROPYTHON"


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (None, "does not run"),
        ("#!/bin/sh\necho Python 3.11\n", "is no MicroPython.*Python 3.11"),
        ("#!/bin/sh\nexit 3\n", "it said nothing"),
    ],
)
def test_a_given_one_that_fails_is_refused_not_replaced(
    bare: Path, monkeypatch: pytest.MonkeyPatch, text: str | None, reason: str
) -> None:
    """Who names one wants that one: the reason, and what to correct."""
    if text:
        program(bare / "mine", text)
    program(bare / "bin" / "micropython", SAYS.format("micropython 1.25.0 64"))
    monkeypatch.setenv("GAZECHAIR_MICROPYTHON", str(bare / "mine"))
    with pytest.raises(gazesetup.NotAvailable, match=f"{reason}.*GAZECHAIR_MICROPYTHON"):
        finder.ensure_micropython(local=bare)


def test_the_cached_one_needs_no_download(bare: Path) -> None:
    """What was unpacked earlier is used as long as it runs."""
    path = program(bare / "micropython" / "micropython", SAYS.format("micropython 1.25.0 32"))
    assert finder.ensure_micropython(local=bare).path == path


def test_a_native_one_is_the_last_resort_and_64_bits_are_said_aloud(
    bare: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the reason why there is no 32-bit one."""
    path = program(bare / "bin" / "micropython", SAYS.format("micropython 1.22.1 64"))
    found = finder.ensure_micropython(local=bare)
    assert found == (path, "MicroPython 1.22.1, 64-bit, on PATH")
    output = capsys.readouterr().out
    assert "64-bit: allocation and integer limits differ" in output


def test_with_none_at_all_the_reason_is_one_line(bare: Path) -> None:
    """What is missing and what to do."""
    with pytest.raises(gazesetup.NotAvailable) as caught:
        finder.ensure_micropython(local=bare)
    assert "apt install micropython" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_one_found_here_behaves_like_micropython(micropython: gazesetup.MicroPython) -> None:
    """The very one that the other tests run on."""
    assert finder.check(micropython.path, "here").description.startswith("MicroPython 1.")
