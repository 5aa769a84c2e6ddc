"""Drives through generated homes, in virtual time: odometry's errors against the truth."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.doubts import PUSHED, STUCK, TURNED
from gazechair.sensing.odometry.odometry import Odometry
from gazemeasure.home import maps
from gazemeasure.home.maps import Judged, MapJudge
from gazemeasure.report import Report, percentile
from gazemeasure.spread import Spread, together
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive

LIDARS = {"two lidars": (FRONT, REAR), "one lidar": (FRONT,)}
_HOMES, _HOMES_QUICK = 100, 4
_SECONDS, _SECONDS_QUICK = 600.0, 40.0
_SPEED_STEP_M_S, _SIGMA_STEP = 0.001, 0.1


@dataclass(frozen=True)
class Job:
    """One drive."""

    seed: int
    seconds: float
    lidars: str


@dataclass(frozen=True)
class Driven:
    """The result of a drive."""

    job: Job
    way_m: float
    end_m: float
    """Position error at the end, with a correct beginning."""
    speed_m_s: Spread
    """Errors of the speed."""
    speed_sigmas: Spread
    """The same errors, in claimed standard deviations."""
    age_s: float
    """Longest time from an estimate's moment until its measurements were complete."""
    alarms: int
    """Number of false reports of a stuck or pushed chair."""
    turned: int
    """Number of false reports of a turned lidar."""
    core: float
    """Share of a core: computing time divided by driving time."""
    map: Judged
    """The map that was made during the drive."""


Run = Callable[[Callable[[Job], Driven], Sequence[Job]], list[Driven]]


def drive(job: Job) -> Driven:
    """Run one drive and judge it."""
    driven = Drive(home_plans.home(job.seed), job.seed, LIDARS[job.lidars])
    odometry = Odometry()
    speeds, sigmas, ages = [], [], []
    began = ended = None
    spent_s = 0.0
    alarms, alarmed = 0, False
    turned, turns = 0, False
    judge = MapJudge(driven.home)
    for event in driven.events(job.seconds):
        if isinstance(event, Motion):
            odometry.motion(event)
            continue
        begin_s = time.process_time()
        found = odometry.piece(event)
        spent_s += time.process_time() - begin_s
        if found is None:
            continue
        was, alarmed = alarmed, bool({STUCK, PUSHED}.intersection(found.doubts))
        alarms += alarmed and not was
        was, turns = turns, TURNED in found.doubts
        turned += turns and not was
        true = driven.truth(found.time_s)
        judge.take(event, found, true)
        began = began or (found, true)
        ended = (found, true)
        speeds.append(found.speed_m_s - true.speed_m_s)
        sigmas.append(speeds[-1] / found.speed_sigma_m_s)
        ages.append(driven.time_s - found.time_s)
    assert began is not None
    assert ended is not None
    turn = math.radians(began[1].heading_deg - began[0].heading_deg)
    c, s = math.cos(turn), math.sin(turn)
    x, y = ended[0].x_m - began[0].x_m, ended[0].y_m - began[0].y_m
    x_true, y_true = ended[1].x_m - began[1].x_m, ended[1].y_m - began[1].y_m
    end_m = math.hypot(c * x - s * y - x_true, s * x + c * y - y_true)
    core = spent_s / job.seconds
    spreads = Spread.of(speeds, _SPEED_STEP_M_S), Spread.of(sigmas, _SIGMA_STEP)
    found_map = judge.judged()
    return Driven(job, driven.way_m, end_m, *spreads, max(ages), alarms, turned, core, found_map)


def kept(row: dict[str, Any]) -> Driven:
    """A result from its JSON row."""
    spreads = {name: Spread(**row[name]) for name in ("speed_m_s", "speed_sigmas")}
    return Driven(**{**row, **spreads, "job": Job(**row["job"]), "map": maps.kept(row["map"])})


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add the rows; `run` maps jobs."""
    homes = _HOMES_QUICK if quick else _HOMES
    seconds = _SECONDS_QUICK if quick else _SECONDS
    fewer = {"two lidars": homes, "one lidar": max(_HOMES_QUICK, homes // 4)}
    jobs = [Job(seed, seconds, lidars) for lidars in LIDARS for seed in range(fewer[lidars])]
    done = run(drive, jobs)
    hours = sum(one.job.seconds for one in done) / 3600.0
    alarms = float(sum(one.alarms for one in done))
    report.add(f"called stuck or pushed without cause, in {hours:.1f} h", alarms, "", 0.0)
    turned = float(sum(one.turned for one in done))
    report.add("  a lidar called turned without cause", turned, "", 0.0)
    for lidars in LIDARS:
        mine = [one for one in done if one.job.lidars == lidars]
        _add_rows(report, lidars, mine)
        maps.add_rows(report, lidars, [one.map for one in mine])


def _add_rows(report: Report, lidars: str, done: list[Driven]) -> None:
    share = [100.0 * one.end_m / one.way_m for one in done if one.way_m > 1.0]
    report.add(f"homes, {lidars}: end error by way, median", percentile(share, 0.5), "%", 0.5)
    report.add("  worst", max(share), "%")
    speeds = together(one.speed_m_s for one in done)
    report.add("  speed error, 95 %", speeds.percentile(95.0), "m/s", 0.03)
    sigmas = together(one.speed_sigmas for one in done)
    report.add("  within two of its own sigmas", 100.0 * sigmas.share_below(2.0), "%")
    # In virtual time no computation takes any: see process.py for the limit.
    age_s = max(one.age_s for one in done)
    report.add("  age when its measurements are whole, most", age_s, "s")
    core = 100.0 * float(np.median([one.core for one in done]))
    report.add("  share of a core, computing alone", core, "%", 25.0)
    way_m = sum(one.way_m for one in done)
    report.note(f"({lidars}: {len(done)} drives, {way_m:.0f} m, {done[0].job.seconds:.0f} s each)")
