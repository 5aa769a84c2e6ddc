"""One turn of one controller on one chair, as a job for a pool of processes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from multiprocessing import get_context
from typing import Any

from gazelink.settings_table import PROFILES, profile_row
from gazemeasure.turn_board import settings_with
from gazemeasure.turn_cases import Drawn
from gazemeasure.turn_judge import Verdict, judge
from gazemeasure.turn_run import turn_of_board
from gazesim.chair import Chair, Parameters

PROCESSES = 2
LIMIT_MS = 10_000  # step_turn_limit_ms of every run: a slow chair takes that long for 90 degrees
KNOWN, DEFAULTS = "known", "defaults"


@dataclass(frozen=True)
class Job:
    """What to run: `controller` is one of the names above."""

    controller: str
    drawn: Drawn


@dataclass(frozen=True)
class Done:
    """What came of it."""

    job: Job
    verdict: Verdict


def run_all(jobs: Sequence[Job]) -> list[Done]:
    """Run the jobs on all of PROCESSES; the answers in their order."""
    with get_context("fork").Pool(PROCESSES) as pool:
        return pool.map(run, jobs, chunksize=4)


def run(job: Job) -> Done:
    """Run one job in this process."""
    drawn = job.drawn
    values = {"profile": PROFILES.index(drawn.profile), "step_turn_limit_ms": LIMIT_MS}
    if job.controller == KNOWN:
        values |= true_rows(drawn.profile, drawn.case.parameters)
    chair = Chair(drawn.profile, drawn.case.seed, drawn.case.parameters)
    turn = turn_of_board(chair, drawn.imu(), settings_with(values), drawn.case.angle_deg)
    return Done(job, judge(turn))


def true_rows(profile: str, parameters: Parameters) -> dict[str, int]:
    """The settings of a profile as they would be if the chair were known exactly."""
    axis: Any = parameters.disturbances.axis(parameters.turn)
    found = {
        "left_q4_dps": axis.positive * 16,
        "right_q4_dps": axis.negative * 16,
        "deadband_permille": axis.deadband * 1000,
        "dead_time_ms": axis.dead_time_s * 1000,
        "lag_ms": axis.lag_s * 1000,
        "accelerate_dps2": axis.accelerate,
        "brake_dps2": axis.brake,
        "tuned": 1,
    }
    row = PROFILES.index(profile)
    return {profile_row(row, name): round(value) for name, value in found.items()}
