"""The benchmark of knowing the home: odometry on a part of a public log, and one short drive."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from gazemeasure import carmen_log
from gazemeasure.home import alarms, odometry
from gazemeasure.home import maps as home_maps
from gazemeasure.home import process as home_process
from gazemeasure.home import record as home_record
from gazemeasure.home.drives import Driven, Job, drive
from gazemeasure.home.localization import Counted
from gazemeasure.home.maps import OFF_STEP_M, WALLS_M, Judged
from gazemeasure.report import Report
from gazemeasure.spread import Spread


def test_a_public_log_without_wheel_encoders() -> None:
    try:
        frames = carmen_log.read(carmen_log.FR079)[:600]
    except carmen_log.NoDataError as error:
        pytest.skip(str(error))
    assert odometry.rmse_m(frames, 1)[0] < 0.15


def test_an_absent_log_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GAZECHAIR_DATA", "/nowhere")
    report = Report("home")
    odometry.measure(report, True, lambda one, seeds: [one(seed) for seed in seeds])
    assert not report.figures
    assert "/nowhere" in report.notes[0]


def test_a_short_drive_is_judged_by_the_truth() -> None:
    found = drive(Job(4, 16.0, "one lidar"))
    assert found.way_m > 0.5
    assert found.end_m < 0.03
    assert found.age_s < 0.1
    assert (found.alarms, found.turned) == (0, 0)
    assert found.map.off_m.percentile(95.0) < WALLS_M
    assert not found.map.doubled
    assert found.speed_m_s.percentile(90.0) < 0.05


@pytest.mark.parametrize(
    "kind", [alarms.STUCK_IN, alarms.STUCK_TURN, alarms.PUSHED_BY, alarms.BACKWARD]
)
def test_what_happens_to_the_chair_is_reported_within_half_a_second(kind: str) -> None:
    assert alarms.reported_after_s((kind, 1)) <= 0.5


@pytest.mark.parametrize(("mb_an_hour", "ok"), [(20.0, True), (200.0, False)])
def test_memory_is_judged_after_an_hour(mb_an_hour: float, ok: bool) -> None:
    report = Report("home")
    points = [(float(s), 100.0 + mb_an_hour * s / 3600.0) for s in range(120)]
    home_process.add_memory(report, points)
    assert report.ok is ok


def test_a_room_that_is_twice_in_the_map_falls_short() -> None:
    right = Judged(Spread.of(np.full(100, 0.01), OFF_STEP_M), 0.05)
    twice = Judged(Spread.of(np.where(np.arange(100) < 10, 0.4, 0.01), OFF_STEP_M), 0.05)
    bent = Judged(Spread.of(np.full(100, 0.01), OFF_STEP_M), 0.5)
    for maps, ok in (([right], True), ([right, twice], False), ([right, bent], False)):
        report = Report("home")
        home_maps.add_rows(report, "two lidars", maps)
        assert report.ok is ok


def run_once(home: int) -> Counted:
    """Results of the starts in a home; it fails when it runs again."""
    Path(f"ran {home}").touch(exist_ok=False)
    found = Counted(right={"as mapped": 9}, unknown={"as mapped": 1}, wrong={"moved": home})
    found.lost_after_s.append(math.inf if home else 1.0)
    found.elsewhere.append(home == 1)
    return found


def test_starts_on_record_are_not_run_again_and_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "starts.json"
    first = home_record.starts(run_once, range(1), file)
    both = home_record.starts(run_once, range(2), file)
    assert both[0] == first[0]
    assert [one.wrong["moved"] for one in both] == [0, 1]
    stored = json.loads(file.read_text())
    assert stored["homes"] == 2
    assert stored["kinds"]["as mapped"] == {"right": 18, "unknown": 2}
    assert stored["kinds"]["moved"] == {"wrong": 1}
    assert stored["claims in homes that are not on the map"] == 1
    assert stored["noticed after, most, s"] == math.inf


def drive_once(job: Job) -> Driven:
    """Result of a drive; it fails when it runs again."""
    Path(f"drove {job.seed}").touch(exist_ok=False)
    speed, sigmas = Spread.of([-0.01, 0.02], 0.001), Spread.of([0.5, 2.5], 0.1)
    walls = Judged(Spread.of([0.005, 0.015, math.inf], OFF_STEP_M), 0.1)
    return Driven(job, 10.0, 0.01 * job.seed, speed, sigmas, 0.05, job.seed, 0, 0.1, walls)


def test_drives_on_record_are_not_run_again_and_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "drives.json"
    jobs = [Job(seed, 600.0, "one lidar") for seed in range(2)]
    first = home_record.drives(drive_once, jobs[:1], file)
    both = home_record.drives(drive_once, jobs, file)
    assert both[0] == first[0]
    assert [one.job for one in both] == jobs
    summary = json.loads(file.read_text())["one lidar"]
    assert (summary["drives"], summary["hours"]) == (2, 0.33)
    assert summary["end error by way, most, %"] == 0.1
    assert summary["called stuck or pushed without cause"] == 1
    assert summary["homes with a doubled room"] == 2
