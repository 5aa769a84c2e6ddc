"""Which PyPy the set-up takes, and what it says when there is none."""

from pathlib import Path

import pytest

import gazesetup
from gazesetup import apt


def program(path: Path, says: str) -> Path:
    """An executable shell script."""
    path.parent.mkdir(parents=True)
    path.write_text(f'#!/bin/sh\necho "{says}"\n')
    path.chmod(0o755)
    return path


@pytest.fixture
def bare(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine with no Debian archive, nothing cached."""
    monkeypatch.setattr(apt, "debian_archives", list)
    return tmp_path


def test_the_cached_one_needs_no_download(bare: Path) -> None:
    path = program(bare / "pypy3" / "pypy3", "pypy True")
    assert gazesetup.ensure_pypy(local=bare) == path


@pytest.mark.parametrize("says", ["pypy False", "cpython True", ""])
def test_another_interpreter_is_no_pypy(bare: Path, says: str) -> None:
    program(bare / "pypy3" / "pypy3", says)
    with pytest.raises(gazesetup.NotAvailable, match="no Debian archive"):
        gazesetup.ensure_pypy(local=bare)


def test_with_none_at_all_the_reason_is_one_line(bare: Path) -> None:
    with pytest.raises(gazesetup.NotAvailable) as caught:
        gazesetup.ensure_pypy(local=bare)
    assert len(str(caught.value).splitlines()) == 1
