"""A file of the state folder: what its health says, and what stays of a damaged one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from gazechair.base.health import DEGRADED, LOST, Health
from gazechair.base.state_file import StateFile
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FloorStore


@pytest.fixture
def health() -> Health:
    return Health("cap")


@pytest.fixture
def file(tmp_path: Path, health: Health) -> StateFile:
    (tmp_path / "cap").write_bytes(b"half")
    return StateFile(tmp_path / "cap", health)


def names(file: StateFile) -> list[str]:
    return sorted(one.name for one in file.path.parent.iterdir())


def test_a_damaged_file_stays_until_it_is_replaced_and_is_kept_then(
    file: StateFile, health: Health
) -> None:
    assert (health.state, file.problem) == ("ok", "")
    file.damaged("half of it is missing")
    assert (health.state, health.reason) == (DEGRADED, "file_damaged")
    assert file.problem == f"{file.path}: half of it is missing"
    assert names(file) == ["cap"]
    for content in (b"new", b"newer"):  # set aside once
        file.replace(content)
        assert (health.state, file.problem) == ("ok", "")
        assert file.path.read_bytes() == content
    assert names(file) == ["cap", "cap.damaged"]
    assert file.path.with_suffix(".damaged").read_bytes() == b"half"


def test_what_the_new_content_holds_is_not_kept_twice(file: StateFile) -> None:
    file.damaged("one line", aside=False)
    file.replace(b"half, and more")
    assert names(file) == ["cap"]


def test_a_file_that_another_process_mended_is_not_set_aside(
    file: StateFile, health: Health
) -> None:
    file.damaged("half of it is missing")
    file.sound()
    assert health.state == "ok"
    file.replace(b"new")
    assert names(file) == ["cap"]


def test_a_content_that_a_power_cut_may_lose_ends_no_report(file: StateFile) -> None:
    file.damaged("half of it is missing")
    file.replace(b"new", durable=False)
    assert file.problem
    file.replace(b"newer")
    assert not file.problem


def test_a_full_disk_leaves_the_damaged_file_for_the_next_try(
    file: StateFile, health: Health
) -> None:
    file.damaged("half of it is missing", LOST)
    assert health.state == LOST
    (file.path.parent / "cap.new").mkdir()
    with pytest.raises(OSError, match=r"cap\.new") as refused:
        file.replace(b"new")
    file.not_kept(refused.value, "the cap ends with this host")
    assert (health.state, health.reason) == (DEGRADED, "not_kept")
    assert file.problem.endswith("; the cap ends with this host")
    (file.path.parent / "cap.new").rmdir()
    file.replace(b"new")
    assert file.path.with_suffix(".damaged").read_bytes() == b"half"


def store_cap(folder: Path) -> None:
    store = SpeedCapStore(folder)
    store.read()
    store.keep(500)
    store.write()


def store_floor(folder: Path) -> None:
    camera = FloorCamera(640, 480, 500.0, 1.0, 20.0, 0.0, 0.0, 0.0)
    FloorStore(folder).keep(Calibration(camera, 0.01, 0.01))


@pytest.mark.parametrize(
    ("name", "store"), [("speed_cap", store_cap), ("camera_floor.json", store_floor)]
)
def test_a_cap_and_a_calibration_that_were_damaged_are_kept_as_well(
    tmp_path: Path, name: str, store: Callable[[Path], None]
) -> None:
    (tmp_path / name).write_bytes(b"half")
    store(tmp_path)
    aside = (tmp_path / name).with_suffix(".damaged")
    assert aside.read_bytes() == b"half"
    assert (tmp_path / name).read_bytes() != b"half"
