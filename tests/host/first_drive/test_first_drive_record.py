"""Results of the first drive survive the host, and are valid only under their conditions."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from gazechair.base.health import HealthRegistry
from gazechair.base.reasons import FIRST_DRIVE
from gazechair.config.settings import LidarConfig
from gazechair.driving import error_handler
from gazechair.first_drive import record as module
from gazechair.first_drive.record import FILE_NAME, Record, fitted_as
from patience import wait_until

LIDAR = LidarConfig(kind="s2", name="front", x_m=0.5)
MASK = {"front": {"fitted": fitted_as(LIDAR), "mask": [[120.0, -120.0]]}}


def test_what_was_found_is_there_after_a_restart(tmp_path: Path) -> None:
    Record(tmp_path).keep("relay", True)
    record = Record(tmp_path)
    record.keep("mask", MASK)
    again = Record(tmp_path)
    assert (again.get("relay"), again.get("mask")) == (True, MASK)
    assert again.masked((LIDAR,))[0].mask == ((120.0, -120.0),)


@pytest.mark.parametrize(
    "other",
    [
        replace(LIDAR, x_m=0.6),
        replace(LIDAR, heading_deg=5.0),
        replace(LIDAR, mask=((90.0, 100.0),)),
        replace(LIDAR, name="rear"),
    ],
)
def test_a_mask_belongs_to_the_lidar_as_it_was_fitted(other: LidarConfig) -> None:
    record = Record(None)
    record.keep("mask", MASK)
    assert not record.has_mask_of(other)
    assert record.masked((other,)) == (other,)


@pytest.mark.parametrize("text", ["", "{", "[]", "7", '{"mask": 3}', '{"mask": {"front": {}}}'])
def test_a_damaged_file_counts_as_none(tmp_path: Path, text: str) -> None:
    (tmp_path / FILE_NAME).write_text(text)
    assert Record(tmp_path).masked((LIDAR,)) == (LIDAR,)


def test_a_damaged_mask_does_not_count(tmp_path: Path) -> None:
    record = Record(None)
    record.keep("mask", {"front": {"fitted": fitted_as(LIDAR), "mask": [[1.0]]}})
    assert record.masked((LIDAR,)) == (LIDAR,)


def test_a_full_disk_keeps_it_until_there_is_space_and_the_caretaker_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "_WRITE_AGAIN_S", 0.05)
    (tmp_path / "state").write_text("in the way")
    parts = HealthRegistry()
    record = Record(tmp_path / "state", parts.part(FIRST_DRIVE))

    def shown() -> list[tuple[str, bool]]:
        problems = error_handler.of_parts(parts.states())
        return [(problem.key, problem.caretaker_only) for problem in problems]

    assert shown() == []
    record.keep("relay", True)
    assert record.get("relay") is True
    assert shown() == [("not_kept", True)]
    (tmp_path / "state").unlink()
    wait_until(lambda: shown() == [])
    assert Record(tmp_path / "state").get("relay") is True


@pytest.mark.parametrize(
    "mask",
    [
        [[-180.0, 180.0]],
        [[-170.0, 170.0]],
        [["0", "9"]],
        [[float("nan"), 0.0]],
        [[10**309, 0.0]],
        [None],
        None,
        3,
    ],
)
def test_a_mask_that_no_configuration_may_have_does_not_count(mask: object) -> None:
    record = Record(None)
    record.keep("mask", {"front": {"fitted": fitted_as(LIDAR), "mask": mask}})
    assert record.masked((LIDAR,)) == (LIDAR,)
    assert not record.has_mask_of(LIDAR)


@pytest.mark.parametrize(
    "found",
    [
        {"distance": "far"},
        {"distance": {"lidars": [], "measured_mm": None, "seen_mm": 5}},
        {"turn": [1]},
        {"turn": {"profile": None, "turned_deg": 3, "wanted_deg": 10}},
        {"turn": {"profile": None, "turned_deg": [float("nan"), 1.0], "wanted_deg": 10}},
        {"distance": {"lidars": [], "measured_mm": 10**309, "seen_mm": 5}},
    ],
)
def test_what_no_page_can_show_does_not_count(tmp_path: Path, found: dict[str, object]) -> None:
    (tmp_path / FILE_NAME).write_text(json.dumps({**found, "relay": True}))
    record = Record(tmp_path)
    assert [record.get(step) for step in found] == [None]
    assert record.get("relay") is True


@pytest.mark.parametrize("how", ["folder", "bytes"])
def test_a_file_that_cannot_be_read_counts_as_none(tmp_path: Path, how: str) -> None:
    if how == "folder":
        (tmp_path / FILE_NAME).mkdir()
    else:
        (tmp_path / FILE_NAME).write_bytes(b"\xff" * 64)
    record = Record(tmp_path)
    record.keep("relay", True)
    assert record.get("relay") is True


def test_a_file_that_cannot_be_read_is_told_until_the_next_result(tmp_path: Path) -> None:
    file = tmp_path / FILE_NAME
    file.symlink_to(file)
    parts = HealthRegistry()
    for _ in range(2):
        record = Record(tmp_path, parts.part("first_drive"))
        assert parts.part("first_drive").reason == "file_damaged"
    record.keep("relay", True)
    assert parts.part("first_drive").reason == "ok"
    assert Record(tmp_path).get("relay") is True
