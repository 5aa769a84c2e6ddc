"""Tuning of straight driving by odometry: the simulated chair in each profile, in generated homes.

Then a step with the result on the same chair, and the stopping distance the board would assume.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.forward import (
    STEP_M,
    ForwardRecording,
    identify,
    step_shares,
)
from gazechair.commissioning.tune.forward_runner import PRESSES, REST_S
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.odometry import Odometry
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row
from gazemeasure.report import Report
from gazesim import home_plans
from gazesim.chair import Chair
from gazesim.home_drive import FRONT, LIDAR_HEIGHT_M, STEP_S, Drive
from gazesim.home_routes import Pose

_SETTLES_S = 1.0
_FREE_M, _SIDE_M = 3.2, 0.4
_STEP_OFF_M = 0.05
_SEEDS, _SEEDS_QUICK = range(10), range(1)
_NEUTRAL = (0.0, 0.0)

Job = tuple[str, int]  # profile, seed
Found = tuple[float, float]  # error of the step; assumed stopping distance by the true one
Run = Callable[[Callable[[Job], Found], Sequence[Job]], list[Found]]


class _Tuned:
    """Replaces the driver: rests, and drives straight on while pressed."""

    def __init__(self, chair: Chair, pose: Pose) -> None:
        self.chair = chair
        self.pose = pose
        self.route: tuple[Pose, ...] = ()
        self.share = 0.0
        chair.place(pose.x_m, pose.y_m, pose.heading_deg)

    @property
    def permille(self) -> tuple[int, int]:
        return round(1000 * self.share), 0

    @property
    def speeds(self) -> tuple[float, float]:
        return self.chair.speed_m_s, self.chair.yaw_rate_deg_s

    def look(self) -> None:
        """Ignores what is ahead."""

    def step(self) -> None:
        """Move for 10 ms."""
        for _ in range(round(STEP_S * 1000)):
            self.chair.step(0.001, (self.share, 0.0))
        x_m, y_m, heading_deg = self.chair.x_m, self.chair.y_m, self.chair.heading_deg
        self.pose = replace(self.pose, x_m=x_m, y_m=y_m, heading_deg=heading_deg)


def _place(driven: Drive) -> Pose | None:
    """A pose with free space ahead; None: there is none."""
    pose = driven.driver.pose
    for heading_deg in range(0, 360, 15):
        angle = math.radians(heading_deg)
        aside = np.array((-_SIDE_M, 0.0, _SIDE_M))
        x, y = pose.x_m - math.sin(angle) * aside, pose.y_m + math.cos(angle) * aside
        metres = driven.home.cast_moving(x, y, np.full(3, angle), LIDAR_HEIGHT_M)
        if metres.min() > _FREE_M:
            return replace(pose, heading_deg=float(heading_deg))
    return None


def recordings(profile: str, seed: int) -> list[ForwardRecording]:
    """Odometry's recordings of the presses, in the first home with space from that seed on."""
    home_seed, pose = seed, None
    while pose is None:
        driven = Drive(home_plans.home(home_seed), home_seed, (FRONT,))
        pose, home_seed = _place(driven), home_seed + 100
    tuned = _Tuned(Chair(profile, seed + 1), pose)
    driven.driver = tuned  # type: ignore[assignment]
    odometry = Odometry()
    plan = [(_SETTLES_S, 0.0)]
    for cap_permille, seconds in PRESSES:
        plan += [(seconds, cap_permille / 1000.0), (REST_S, 0.0)]
    outputs: list[tuple[float, float]] = []
    places: list[tuple[float, float, float]] = []
    bounds = np.cumsum([seconds for seconds, _ in plan])
    for event in driven.events(float(bounds[-1])):
        at = min(int(np.searchsorted(bounds, driven.time_s)), len(plan) - 1)
        tuned.share = plan[at][1]
        if isinstance(event, Motion):
            outputs.append((event.time_s, tuned.share))
            odometry.motion(event)
            continue
        found = odometry.piece(event)
        if found is not None:
            places.append((found.time_s, found.x_m, found.y_m))
    return [
        ForwardRecording.of(outputs, places, float(begin_s) - 0.5, float(end_s))
        for begin_s, end_s in zip(bounds[:-2:2], bounds[2::2], strict=True)
    ]


def _driven_m(chair: Chair, shares: Sequence[float] | np.ndarray) -> float:
    before = chair.x_m, chair.y_m
    for share in shares:
        for _ in range(10):
            chair.step(0.001, (float(share), 0.0))
    return math.dist(before, (chair.x_m, chair.y_m))


def _rested(profile: str, seed: int) -> Chair:
    chair = Chair(profile, seed)
    chair.step(0.001, _NEUTRAL)
    return chair


def judged(job: Job) -> Found:
    """Tune that profile, then drive; (inf, 0): it cannot be tuned."""
    profile, seed = job
    try:
        numbers = identify(recordings(profile, seed))
        brake_m_s2 = numbers.brake_row_mm_s2(_acts_s(profile)) / 1000.0
    except TuneError:
        return math.inf, 0.0
    permille, ramp_ms = (TABLE[index_of(name)][1] for name in ("linear_permille", "step_ramp_ms"))
    most_ms = TABLE[index_of("step_forward_ms")][3]
    step_ms = numbers.step_ms(permille, ramp_ms, most_ms)
    step_m = _driven_m(_rested(profile, seed), step_shares(permille, ramp_ms, step_ms))
    return abs(step_m - STEP_M), min(_assumed(profile, seed, brake_m_s2))


def _assumed(profile: str, seed: int, brake_m_s2: float) -> Sequence[float]:
    shares = []
    for share in (0.3, 0.6, 1.0):
        chair = _rested(profile, seed)
        _driven_m(chair, [share] * 400)
        speed = chair.speed_m_s
        true_m = _driven_m(chair, [0.0] * 300)
        shares.append((speed * _acts_s(profile) + speed**2 / (2.0 * brake_m_s2)) / true_m)
    return shares


def _acts_s(profile: str) -> float:
    row = PROFILES.index(profile)
    names = (profile_row(row, "dead_time_ms"), profile_row(row, "lag_ms"))
    ms = sum(TABLE[index_of(name)][1] for name in names)
    return float(max(TABLE[index_of("reaction_ms")][1], ms) / 1000.0)


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add the rows; `run` maps jobs."""
    seeds = _SEEDS_QUICK if quick else _SEEDS
    found = run(judged, [(profile, seed) for profile in PROFILES for seed in seeds])
    name = f"tuned straight on: a step of {STEP_M:g} m ends off by, worst of {len(found)}"
    report.add(name, 100.0 * max(one[0] for one in found), "cm", 100.0 * _STEP_OFF_M)
    least = min(one[1] for one in found)
    report.add("  stopping distance assumed by the true one, least", least, "", 1.0, at_least=True)
