"""Files of the state folder: replaced as a whole, synced, and never preventing a start."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from fulldisk import full
from gazechair.base.state_folder import replace_file, set_aside


def test_it_is_on_the_disk_before_it_replaces_the_old_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    order: list[str] = []
    fsync, replace = os.fsync, os.replace
    monkeypatch.setattr(
        os,
        "fsync",
        lambda handle: order.append(os.readlink(f"/proc/self/fd/{handle}")) or fsync(handle),
    )
    monkeypatch.setattr(
        os, "replace", lambda old, new: order.append("replace") or replace(old, new)
    )
    file = tmp_path / "new" / "cap"
    replace_file(file, b"1")
    assert order == [f"{file}.new", "replace", str(file.parent)]
    assert file.read_bytes() == b"1"
    assert file.stat().st_mode & 0o777 == 0o600
    assert file.parent.stat().st_mode & 0o777 == 0o700
    replace_file(file, b"2", durable=False)
    assert file.read_bytes() == b"2"
    assert list(file.parent.iterdir()) == [file]


def test_what_an_earlier_try_left_is_replaced_and_a_link_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "other").write_text("other")
    (tmp_path / "cap.new").symlink_to(tmp_path / "other")
    replace_file(tmp_path / "cap", b"1")
    assert (tmp_path / "other").read_text() == "other"
    assert (tmp_path / "cap").read_bytes() == b"1"


def test_two_files_of_one_name_and_two_suffixes_have_a_temporary_name_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a map and its drawing, by two processes at once."""
    fsync = os.fsync

    def meanwhile(handle: int) -> None:
        monkeypatch.setattr(os, "fsync", fsync)
        replace_file(tmp_path / "a.svg", b"drawing")
        fsync(handle)

    monkeypatch.setattr(os, "fsync", meanwhile)
    replace_file(tmp_path / "a.map", b"map")
    assert (tmp_path / "a.map").read_bytes() == b"map"
    assert (tmp_path / "a.svg").read_bytes() == b"drawing"


def test_on_a_full_disk_half_a_file_does_not_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "file.map"
    path.write_bytes(b"old")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        replace_file(path, b"new")
    assert [one.name for one in tmp_path.iterdir()] == ["file.map"]
    assert path.read_bytes() == b"old"


@pytest.mark.parametrize("step", ["open", "fsync", "replace"])
def test_a_damaged_file_stays_where_it_is_until_the_new_one_is_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str
) -> None:
    path = tmp_path / "alerts.jsonl"
    path.write_text("half")
    step_of_old = getattr(os, step)

    def full(what: object, *more: Any) -> Any:
        if step == "replace" and not str(what).endswith(".new"):
            return step_of_old(what, *more)
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, step, full)
        with pytest.raises(OSError, match="No space"):
            replace_file(path, b"new", damaged=True)
    assert [one.name for one in tmp_path.iterdir()] == ["alerts.jsonl"]
    assert path.read_text() == "half"
    replace_file(path, b"new", damaged=True)
    assert (tmp_path / "alerts.damaged").read_text() == "half"
    assert path.read_bytes() == b"new"


def test_a_folder_in_its_place_is_set_aside(tmp_path: Path) -> None:
    file = tmp_path / "cap"
    for _ in range(10):
        file.unlink(missing_ok=True)
        file.mkdir()
        (file / "something").touch()
        replace_file(file, b"1")
        assert file.read_bytes() == b"1"
    assert (tmp_path / "cap.damaged9" / "something").exists()


def test_set_aside_leaves_what_was_set_aside_before(tmp_path: Path) -> None:
    for content in ("first", "second"):
        (tmp_path / "cap").write_text(content)
        set_aside(tmp_path / "cap")
    assert (tmp_path / "cap.damaged").read_text() == "first"
    assert (tmp_path / "cap.damaged1").read_text() == "second"
