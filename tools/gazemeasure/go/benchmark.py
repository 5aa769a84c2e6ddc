"""Measures how the chair drives itself from place to place: missions in generated homes.

The board's real core decides in every millisecond which output it permits; only the simulator's
truth judges. A mission has one press, as by a person: if the board ends it, the mission has failed.
See rig.py for the parts, missions.py for the random missions, ideal.py for the reference times, and
scenes.py for missions of the whole firmware and host, which locate themselves.
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from gazemeasure.go import another, assist_set, floor, rows, scenes
from gazemeasure.go import line as go_line
from gazemeasure.go import process as go_process
from gazemeasure.go import record as go_record
from gazemeasure.go.missions import (
    DOORS,
    FOREIGN,
    HOMES,
    KINDS,
    ONE,
    PEOPLE,
    TWO,
    Result,
    kept,
    mission,
)
from gazemeasure.on_record import Job
from gazemeasure.pools import PROCESSES
from gazemeasure.report import Report, percentile

_QUICK = 3
_MOST_SPENT = 7
_LEAST_ARRIVED = {TWO: 99.0, ONE: 95.0, FOREIGN: 95.0, PEOPLE: 95.0, DOORS: 99.0, HOMES: 99.0}
# What docs/going-lab.md recorded, 0.65 and 2.3, and a tenth.
_ACCELERATION_M_S2, _JERK_M_S3 = 0.72, 2.5

_ELSEWHERE = (
    "P17 to P20 at 10^6 random ticks: tools/prove, recorded in docs/proof.json.",
    "Following a person: gazechair measure person.",
)
_ONE_LIDAR = "one lidar in front: what turns sweep is unseen, so the board lets no auto motion turn"


def measure(quick: bool) -> Report:
    """Run everything; see Report."""
    report = Report("go: from place to place by itself")
    jobs = [
        Job(kind, seed)
        for kind, count in KINDS.items()
        for seed in range(_QUICK if quick else count)
    ]
    file = None if quick else go_record.FILE
    done = go_record.gather(jobs, mission, kept, PROCESSES, file)
    for kind in KINDS:
        add_kind(report, kind, [one for one in done if one.job.kind == kind])
    plan_s = [value for one in done for value in one.plan_s]
    report.add("planning, 95 %", percentile(plan_s, 0.95), "s CPU", 0.5)
    report.add("a step of the mission, 95 %, most", max(one.step_ms for one in done), "ms CPU")
    add_comfort(report, done)
    _add_spent(report, done)
    scenes.measure(report, quick, PROCESSES)
    another.measure(report, quick, PROCESSES)
    floor.measure(report, quick)
    go_line.measure(report, quick)
    assist_set.measure(report, quick)
    go_process.measure(report)
    report.note(_ONE_LIDAR)
    for line in _ELSEWHERE:
        report.note(line)
    rows.note_failures(report, done)
    return report


def _add_spent(report: Report, done: list[Result]) -> None:
    """Add how the time of all missions was spent, in percent, the largest share first."""
    total: Counter[str] = Counter()
    for one in done:
        total.update(one.spent_s)
    for what, seconds in total.most_common(_MOST_SPENT):
        report.add(f"time: {what.strip()}", 100.0 * seconds / total.total(), "%")


def add_comfort(report: Report, done: list[Result]) -> None:
    """Add how smoothly the missions were driven."""
    most = max(one.acceleration for one in done)
    report.add("acceleration, most", most, "m/s2", _ACCELERATION_M_S2)
    jerk = float(np.median([one.jerk for one in done]))
    report.add("jerk, 99 % of a mission, median of missions", jerk, "m/s3", _JERK_M_S3)


def add_kind(report: Report, kind: str, done: list[Result]) -> None:
    """Add the missions of that kind."""
    rows.add_arrived(report, kind, done, _LEAST_ARRIVED[kind])
    rows.add_gap(report, done)
    rows.add_ratio(report, done, rows.RATIO if kind in (TWO, ONE, HOMES) else None)
