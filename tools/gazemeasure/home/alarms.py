"""How soon odometry reports a chair that is stuck, pushed or turned by hand, in generated homes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gazechair.sensing.odometry.doubts import PUSHED, STUCK
from gazechair.sensing.odometry.odometry import Motion, Odometry
from gazemeasure.report import Report, percentile
from gazesim import home_plans
from gazesim.home_drive import FRONT, STEP_S, Drive
from gazesim.home_routes import Pose

STUCK_IN, PUSHED_BY, TURNED_BY = "stuck", "pushed", "turned by hand"
_REPORTS = {STUCK_IN: STUCK, PUSHED_BY: PUSHED, TURNED_BY: PUSHED}
_STARTS_S = 0.6  # after a command, every chair has begun to move by then
_MOVES_M_S, _MOVES_DEG_S = 0.06, 6.0
_QUIET_S, _LASTS_S = 4.0, 1.6
_SEEDS, _SEEDS_QUICK = range(100), range(3)
_LIMIT_S = 0.5

Job = tuple[str, int]  # what happens, seed
Run = Callable[[Callable[[Job], float], Sequence[Job]], list[float]]


@dataclass
class _Disturbed:
    """Replaces the driver: the chair is held, pushed or turned."""

    pose: Pose
    kind: str
    chance: random.Random

    def __post_init__(self) -> None:
        self.route: tuple[Pose, ...] = ()
        self.permille = (0, 0)
        self.speeds = (0.0, 0.0)
        self.since_s: float | None = None
        """Since when it should be reported, s."""
        self._now_s = 0.0
        self._begins_s = _QUIET_S + self.chance.random()
        self._command = self.chance.choice(((self.chance.randint(600, 1000), 0), (0, 900)))
        self._way = self.chance.choice((-1.0, 1.0))
        self._speed = self.chance.uniform(0.15, 0.3)
        self._ramp = self.chance.uniform(0.3, 1.0)

    def look(self) -> None:
        """Ignores what is ahead."""

    def step(self) -> None:
        """Move for 10 ms."""
        self._now_s += STEP_S
        passed_s = self._now_s - self._begins_s
        if passed_s < 0.0:
            return
        if self.kind == STUCK_IN:
            self.permille = self._command
            self.since_s = self._begins_s + _STARTS_S
            return
        speed = self._way * min(self._speed, self._ramp * passed_s)
        turn_deg_s = 0.0
        if self.kind == TURNED_BY:
            speed, turn_deg_s = 0.0, 100.0 * speed
        angle = math.radians(self.pose.heading_deg)
        self.pose = replace(
            self.pose,
            x_m=self.pose.x_m + math.cos(angle) * speed * STEP_S,
            y_m=self.pose.y_m + math.sin(angle) * speed * STEP_S,
            heading_deg=self.pose.heading_deg + turn_deg_s * STEP_S,
        )
        self.speeds = speed, turn_deg_s
        if abs(speed) > _MOVES_M_S or abs(turn_deg_s) > _MOVES_DEG_S:
            self.since_s = self.since_s or self._now_s


def reported_after_s(job: Job) -> float:
    """Seconds until the event is reported; inf: not at all, or before it happened."""
    kind, seed = job
    driven = Drive(home_plans.home(seed), seed, (FRONT,))
    disturbed = _Disturbed(driven.driver.pose, kind, random.Random(f"{kind} {seed}"))
    driven.driver = disturbed  # type: ignore[assignment]
    odometry = Odometry()
    for event in driven.events(_QUIET_S + 1.0 + _LASTS_S):
        if isinstance(event, Motion):
            odometry.motion(event)
            continue
        found = odometry.piece(event)
        if found is not None and {STUCK, PUSHED}.intersection(found.doubts):
            early = disturbed.since_s is None or _REPORTS[kind] not in found.doubts
            return math.inf if early else driven.time_s - (disturbed.since_s or 0.0)
    return math.inf


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add a row for each event; `run` maps jobs."""
    seeds = _SEEDS_QUICK if quick else _SEEDS
    for kind in _REPORTS:
        after_s = run(reported_after_s, [(kind, seed) for seed in seeds])
        report.add(f"{kind}: reported, slowest of {len(after_s)}", max(after_s), "s", _LIMIT_S)
        report.add("  median", percentile(after_s, 0.5), "s")
