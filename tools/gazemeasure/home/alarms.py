"""How soon odometry reports that a chair is stuck, pushed, or does not obey, in generated homes."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.doubts import CORRIDOR, PUSHED, STUCK
from gazechair.sensing.odometry.odometry import Odometry
from gazemeasure.report import Report, percentile
from gazesim import home_plans
from gazesim.home_drive import FRONT, STEP_S, Drive
from gazesim.home_routes import Pose

STUCK_IN, PUSHED_BY, TURNED_BY = "stuck", "pushed", "turned by hand"
STUCK_TURN, STUCK_LOW = "stuck in a turn, as it turned before", "stuck at less"
BACKWARD, SPINS = "told forward, rolls backward", "told forward, spins"
_REPORTS = {
    STUCK_IN: STUCK,
    STUCK_TURN: STUCK,
    STUCK_LOW: STUCK,
    PUSHED_BY: PUSHED,
    TURNED_BY: PUSHED,
    BACKWARD: PUSHED,
    SPINS: PUSHED,
}
_STARTS_S = 0.6  # after a command, every chair has begun to move by then
_STARTS_LOW_S = 1.2  # on one that does not move every chair
_USUAL_TURN = 500  # permille, as a profile is without tuning
_TURNED_S, _TURNED_DEG_S = (1.0, 2.0), 12.0
_SPINS_DEG_S, _CASTERS_S = 20.0, 0.2  # casters do that for a moment
_MOVES_M_S, _MOVES_DEG_S = 0.06, 6.0
_QUIET_S, _LASTS_S = 4.0, 1.8
_SEEDS, _SEEDS_QUICK = range(100), range(3)
_LIMIT_S = 0.5
_MOST_UNSEEN = 3  # of 100

Job = tuple[str, int]  # what happens, seed


@dataclass(frozen=True)
class Told:
    """What odometry reports of an event."""

    after_s: float
    """Seconds until it is reported; inf: not at all, or before it happened."""
    unseen_after_s: float = math.inf
    """Seconds until it is reported that the surfaces show no motion along a corridor; or inf."""

    @property
    def unseen(self) -> bool:
        """True if that is reported in time, instead of the event."""
        return self.after_s > _LIMIT_S >= self.unseen_after_s


Run = Callable[[Callable[[Job], Told], Sequence[Job]], list[Told]]


@dataclass
class _Disturbed:
    """Replaces the driver: the chair is held, pushed or turned, or does not obey."""

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
        drives = self.chance.randint(600, 1000), 0
        self._command = {
            STUCK_IN: self.chance.choice((drives, (0, 900))),
            STUCK_TURN: (0, _USUAL_TURN),
            STUCK_LOW: self.chance.choice(((self.chance.randint(400, 599), 0), (0, _USUAL_TURN))),
            BACKWARD: drives,
            SPINS: drives,
        }.get(self.kind, (0, 0))
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
            if self.kind == STUCK_TURN:
                self._turn_once()
            return
        self.permille = self._command
        if _REPORTS[self.kind] == STUCK:
            low = self.kind == STUCK_LOW
            self.since_s = self._begins_s + (_STARTS_LOW_S if low else _STARTS_S)
            return
        speed = self._way * min(self._speed, self._ramp * passed_s)
        turn_deg_s, most_deg_s, lasts_s = 0.0, _MOVES_DEG_S, 0.0
        if self.kind == TURNED_BY:
            speed, turn_deg_s = 0.0, 100.0 * speed
        elif self.kind == BACKWARD:
            speed = -abs(speed)
        elif self.kind == SPINS:
            speed, turn_deg_s = 0.0, 200.0 * speed
            most_deg_s, lasts_s = _SPINS_DEG_S, _CASTERS_S
        self._move(speed, turn_deg_s)
        if abs(speed) > _MOVES_M_S or abs(turn_deg_s) > most_deg_s:
            self.since_s = self.since_s or self._now_s + lasts_s

    def _turn_once(self) -> None:
        turns = _TURNED_S[0] <= self._now_s < _TURNED_S[1]
        self.permille = (0, _USUAL_TURN if turns else 0)
        self._move(0.0, _TURNED_DEG_S if turns else 0.0)

    def _move(self, speed: float, turn_deg_s: float) -> None:
        angle = math.radians(self.pose.heading_deg)
        self.pose = replace(
            self.pose,
            x_m=self.pose.x_m + math.cos(angle) * speed * STEP_S,
            y_m=self.pose.y_m + math.sin(angle) * speed * STEP_S,
            heading_deg=self.pose.heading_deg + turn_deg_s * STEP_S,
        )
        self.speeds = speed, turn_deg_s


def told(job: Job) -> Told:
    """Drive until the event is reported."""
    kind, seed = job
    driven = Drive(home_plans.home(seed), seed, (FRONT,))
    disturbed = _Disturbed(driven.driver.pose, kind, random.Random(f"{kind} {seed}"))
    driven.driver = disturbed  # type: ignore[assignment]
    odometry, unseen_after_s = Odometry(), math.inf
    for event in driven.events(_QUIET_S + 1.0 + _LASTS_S):
        if isinstance(event, Motion):
            odometry.motion(event)
            continue
        found = odometry.piece(event)
        if found is None:
            continue
        after_s = math.inf if disturbed.since_s is None else driven.time_s - disturbed.since_s
        if {STUCK, PUSHED}.intersection(found.doubts):
            early = math.isinf(after_s) or _REPORTS[kind] not in found.doubts
            return Told(math.inf if early else after_s, unseen_after_s)
        if CORRIDOR in found.doubts:
            unseen_after_s = min(unseen_after_s, after_s)
    return Told(math.inf, unseen_after_s)


def measure(report: Report, quick: bool, run: Run) -> None:
    """Add a row for each event; `run` maps jobs."""
    seeds = _SEEDS_QUICK if quick else _SEEDS
    for kind in _REPORTS:
        done = run(told, [(kind, seed) for seed in seeds])
        after_s = [one.after_s for one in done if not one.unseen]
        report.add(f"{kind}: reported, slowest of {len(after_s)}", max(after_s), "s", _LIMIT_S)
        report.add("  median", percentile(after_s, 0.5), "s")
        unseen = len(done) - len(after_s)
        report.add(
            "  in a corridor that shows nothing, and that reported", unseen, "", _MOST_UNSEEN
        )
