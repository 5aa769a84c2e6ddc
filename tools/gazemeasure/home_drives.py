"""Drives through generated homes, in virtual time: odometry's errors against the truth."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gazechair.sensing.odometry.doubts import PUSHED, STUCK
from gazechair.sensing.odometry.odometry import Motion, Odometry
from gazemeasure.home_maps import Judged, MapJudge
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive

Array = NDArray[np.float64]

LIDARS = {"two lidars": (FRONT, REAR), "one lidar": (FRONT,)}


@dataclass(frozen=True)
class Job:
    """One drive."""

    seed: int
    seconds: float
    lidars: str


@dataclass(frozen=True)
class Driven:
    """What came of it. Arrays: an entry each estimate."""

    job: Job
    way_m: float
    end_m: float
    """Error of the place at the end, the beginning being right."""
    speed_m_s: Array
    """Errors."""
    speed_sigmas: Array
    """The same, in the standard deviations that were claimed."""
    age_s: Array
    """When the measurements were whole, since the time that the estimate is of."""
    alarms: int
    """How often it was called stuck or pushed: nobody held or pushed it."""
    core: float
    """Share of a core: computing time by driving time."""
    map: Judged
    """The map that was made on the way."""


def drive(job: Job) -> Driven:
    """Drive, and judge."""
    driven = Drive(home_plans.home(job.seed), job.seed, LIDARS[job.lidars])
    odometry = Odometry()
    speeds, sigmas, ages = [], [], []
    began = ended = None
    spent_s = 0.0
    alarms, alarmed = 0, False
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
    arrays = (np.array(speeds), np.array(sigmas), np.array(ages))
    return Driven(job, driven.way_m, end_m, *arrays, alarms, core, judge.judged())
