"""The all-day benchmark in small and in virtual time: a minute's drive, cuts, replays, slopes."""

from __future__ import annotations

import math
import os
import random
from pathlib import Path

import pytest

from gazechair.driving.speed_cap_store import KeptCap
from gazemeasure import allday_power, allday_replay, allday_service, allday_virtual
from gazemeasure.allday_chair import DayChair
from gazemeasure.allday_faults import DAEMON, faults, shuffled
from gazemeasure.growth import Holding, slope_per_hour
from gazemeasure.report import Report
from gazereplay.replay import replay


def test_a_slope_is_per_hour_and_a_peak_does_not_move_it() -> None:
    points = [(float(s), 100.0 + s / 3600) for s in range(0, 3600, 10)]
    assert slope_per_hour(points) == pytest.approx(1.0)
    points[20] = (200.0, 5000.0)
    assert slope_per_hour(points) == pytest.approx(1.0, rel=0.01)
    assert slope_per_hour([(float(s), 7.0) for s in range(100)]) == 0.0
    assert math.isnan(slope_per_hour(points[:2]))


def test_what_a_process_holds() -> None:
    holding = Holding()
    holding.look(os.getpid(), 1.0)
    assert holding.memory_mb[0][1] > 5
    assert holding.threads[0][1] >= 1
    assert holding.files[0][1] >= 3


def test_every_part_fails_in_every_way_before_one_does_again() -> None:
    count = len(faults())
    plan = shuffled(random.Random(1), 2 * count)
    assert set(plan[:count]) == set(plan[count:]) == set(faults())
    assert sum(fault.part == DAEMON for fault in plan) == 6


def test_the_unit_file_is_what_systemd_does() -> None:
    assert allday_service.setting_s("RestartSec") == 0.1
    assert allday_service.setting_s("WatchdogSec") == 2.0
    with pytest.raises(KeyError):
        allday_service.setting_s("NoSuchSetting")


def test_some_seconds_of_a_day() -> None:
    report = Report("")
    day = allday_virtual.live(allday_virtual.Life(3.0, seed=14, fault_each=1))
    allday_virtual.add_rows(report, [day], 3.0)
    figures = {figure.name.strip(): figure.value for figure in report.figures}
    assert figures["faults while driving"] >= 1
    assert figures["not driving again by arm and press"] == 0, report.table()
    assert figures["driving again, p95"] <= 5


def test_a_drive_is_replayed_equal(tmp_path: Path) -> None:
    chair = DayChair(tmp_path, record=True)
    allday_replay.cable(chair)
    result = replay(chair.close())
    assert result.difference is None
    assert result.armed > 300


@pytest.mark.parametrize("store", allday_power.STORES, ids=lambda store: str(store.file))
def test_a_file_of_the_state_folder_is_old_or_new_wherever_the_power_goes(
    store: allday_power.Store,
) -> None:
    dice = random.Random(1)
    cuts = allday_power.cut_writing(store, 20, dice)
    assert (cuts.half, cuts.dead) == (0, [])
    assert allday_power.cut_file(store, 20, dice).dead == []
    assert allday_power.unsynced(store) == 0


def test_a_file_that_is_half_written_or_replaced_too_soon_is_found(tmp_path: Path) -> None:
    def write(folder: Path, number: int) -> None:
        (folder / "speed_cap").write_text(f"{number * 111}\n")

    careless = allday_power.Store("speed_cap", write, lambda at: KeptCap(at).read())
    assert allday_power.cut_writing(careless, 20, random.Random(1)).half > 0
    assert allday_power.unsynced(careless) > 0
