"""A stored map is kept current by what drives find, and by nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fulldisk import full
from gazechair.sensing.mapping import keeping
from gazechair.sensing.mapping.keeping import APART_S
from gazechair.sensing.mapping.locating.looks import Seen
from keepingrig import AHEAD, LOCATION, Drives, estimate


@pytest.fixture
def drives(tmp_path: Path) -> Drives:
    return Drives(tmp_path)


def test_one_drive_counts_once_however_often_the_host_is_started(drives: Drives) -> None:
    drives.go(200)
    assert drives.counted() == 1
    for _ in range(3):
        drives.utc_s += 600.0
        drives.start()
        drives.go(200)
    assert drives.counted() == 1
    drives.utc_s += APART_S
    drives.start()
    drives.go(200)
    assert drives.counted() == 2


def test_the_third_drive_hours_apart_changes_the_stored_map_and_it_can_be_had_back(
    drives: Drives,
) -> None:
    for _ in range(3):
        assert drives.stored().same_as(drives.first)
        drives.start()
        drives.go(70)
        drives.utc_s += 2 * APART_S
    added = drives.stored().occupied & ~drives.first.occupied
    assert 4 <= added.sum() <= 6
    assert added[30, 18:22].all()
    assert drives.store.take_back("a")
    assert drives.stored().same_as(drives.first)


def test_looks_just_before_the_place_was_lost_do_not_count(drives: Drives) -> None:
    drives.go(70, unsure_every=4)  # never known for five seconds
    assert drives.counted() == 0


def test_a_chair_that_only_stands_has_seen_one_thing_once(drives: Drives) -> None:
    for step in range(200):
        seen = Seen(AHEAD, np.zeros(3), estimate(float(step)))
        drives.keeping.look("a", drives.first, seen, LOCATION)
    assert drives.counted() == 0


def test_a_disk_that_is_full_is_no_reason_to_stop(
    drives: Drives, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("gazechair.sensing.mapping.upkeep.replace_file", full)
    drives.go(70)
    assert drives.counted() == 0


def test_a_map_that_is_too_large_to_be_kept_current_is_told_once(
    drives: Drives, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(keeping, "_MOST_CELLS", 1000)
    drives.go(200)
    assert [one.getMessage() for one in caplog.records] == [
        "map a is not kept current: it has 1600 cells, more than 1000"
    ]
    assert drives.counted() == 0
