"""Files that a command writes for a person."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from fulldisk import full
from gazechair.base.output_file import write_output
from gazechair.base.user_error import UserError


def test_it_replaces_what_was_there_through_a_link_too(tmp_path: Path) -> None:
    (tmp_path / "plan").symlink_to(tmp_path / "new" / "plan.svg")
    for content in (b"first", b"second"):
        write_output(tmp_path / "plan", content)
        assert (tmp_path / "new" / "plan.svg").read_bytes() == content
    assert (tmp_path / "plan").is_symlink()
    assert [one.name for one in (tmp_path / "new").iterdir()] == ["plan.svg"]


def test_who_may_read_it_is_for_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_output(tmp_path / "new" / "plan.svg", b"")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new" / "plan.svg").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o750


def test_a_folder_in_its_place_stays(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="can't be written: Is a directory"):
        write_output(tmp_path, b"")
    assert tmp_path.is_dir()


def test_a_pipe_stays_one(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_output(tmp_path / "pipe", b"plan")
    assert os.read(reader, 9) == b"plan"
    os.close(reader)


def test_on_a_full_disk_the_old_one_stays_and_no_half_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "plan.svg"
    path.write_bytes(b"old")

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(UserError, match=r"plan\.svg can't be written: No space left on device"):
        write_output(path, b"new")
    assert [one.name for one in tmp_path.iterdir()] == ["plan.svg"]
    assert path.read_bytes() == b"old"
