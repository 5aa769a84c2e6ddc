"""The benchmark of knowing the home: odometry on a part of a public log, and one short drive."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gazemeasure import carmen_log
from gazemeasure.home import alarms, benchmark, odometry
from gazemeasure.home import maps as home_maps
from gazemeasure.home import process as home_process
from gazemeasure.home import record as home_record
from gazemeasure.home.drives import Driven, Job, drive
from gazemeasure.home.faults import Drove
from gazemeasure.home.localization import Counted
from gazemeasure.home.maps import OFF_STEP_M, WALLS_M, Judged
from gazemeasure.home.upkeep import Kept
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
    assert alarms.told((kind, 1)).after_s <= 0.5


@pytest.mark.parametrize(
    ("after_s", "unseen_after_s", "ok"),
    [(0.4, math.inf, True), (0.6, math.inf, False), (math.inf, 0.3, True), (0.6, 0.6, False)],
)
def test_what_is_reported_late_falls_short_unless_it_says_that_it_sees_no_motion(
    after_s: float, unseen_after_s: float, ok: bool
) -> None:
    report, one = Report("home"), alarms.Told(0.4)
    told = [alarms.Told(after_s, unseen_after_s), one, one]
    alarms.measure(report, True, lambda _, jobs: told)
    assert report.ok is ok


def test_few_events_may_be_unseen() -> None:
    report = Report("home")
    alarms.measure(
        report, False, lambda _, jobs: [alarms.Told(math.inf, 0.3)] * 4 + [alarms.Told(0.4)]
    )
    assert not report.ok


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
    stored = replace(home_record.STARTS, file=file)
    first = stored.each(run_once, range(1))
    both = stored.each(run_once, range(2))
    assert both[0] == first[0]
    assert [one.wrong["moved"] for one in both] == [0, 1]
    summary = json.loads(file.read_text())
    assert summary["homes"] == 2
    assert summary["kinds"]["as mapped"] == {"right": 18, "unknown": 2}
    assert summary["kinds"]["moved"] == {"wrong": 1}
    assert summary["claims in homes that are not on the map"] == 1
    assert summary["noticed after, most, s"] == math.inf


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
    stored = replace(home_record.DRIVES, file=file)
    first = stored.each(drive_once, jobs[:1])
    both = stored.each(drive_once, jobs)
    assert both[0] == first[0]
    assert [one.job for one in both] == jobs
    summary = json.loads(file.read_text())["one lidar"]
    assert (summary["drives"], summary["hours"]) == (2, 0.33)
    assert summary["end error by way, most, %"] == 0.1
    assert summary["called stuck or pushed without cause"] == 1
    assert summary["homes with a doubled room"] == 2


_OFF_M = Spread.of([0.01, math.inf], OFF_STEP_M)
_RESULTS: dict[str, tuple[home_record.Stored[Any, Any], Any, Any]] = {
    "foreign": (home_record.FOREIGN, ("drawn", 1), Counted(right={"drawn": 2})),
    "faults": (home_record.FAULTS, ("bumped", 1), Drove(0, 5, 9, 0, math.inf, _OFF_M)),
    "upkeep": (home_record.UPKEEP, 1, Kept(_OFF_M, _OFF_M, 3, 2, 1, 0, 0, 0)),
    "alarms": (home_record.ALARMS, ("stuck", 1), alarms.Told(math.inf, 0.3)),
    "forward": (home_record.FORWARD, ("rnet", 1), (0.01, 1.2)),
}


def once(ran: Path, result: object, _job: object) -> object:
    """The result; it fails when it runs again."""
    ran.touch(exist_ok=False)
    return result


@pytest.mark.parametrize("part", _RESULTS)
def test_what_is_on_record_is_the_result_and_is_not_measured_again(
    part: str, tmp_path: Path
) -> None:
    stored, job, result = _RESULTS[part]
    stored = replace(stored, file=tmp_path / "record.json")
    run = partial(once, tmp_path / "ran", result)
    assert stored.each(run, [job]) == [result]
    assert stored.each(run, [job]) == [result]


def test_each_part_of_the_benchmark_has_a_file_of_its_own() -> None:
    parts = [stored.file for _, stored in benchmark._PARTS]
    assert None not in parts
    assert len(set(parts)) == len(parts)
