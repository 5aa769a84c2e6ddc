"""A chair that drives itself somewhere, in virtual time: firmware core, clearance, mission, twin.

Every millisecond a tick of the board's real core (safety, motion, obstacles), every 10 ms the
chair, every 100 ms a turn of the lidars and the host's clearance, every 50 ms the mission. Only the
truth judges: footprint against walls, arrival by the true pose.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gazeboard.core.stopping import Stopping
from gazechair.base.footprint import Footprint
from gazechair.board.board_commands import Clearance
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import costmap_of
from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import ARRIVED, BLOCKED, Mission
from gazechair.going.plan import Path, Planner, Pose
from gazechair.going.planning import Planned
from gazechair.going.rolled import Located
from gazechair.sensing.clearance.evaluate import Evaluator
from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import to_chair
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazelink import codes
from gazelink.settings_table import PROFILES, TABLE
from gazemeasure.go.board import BoardCore, HalfTurnEye
from gazemeasure.go.ideal import Permitted, ideal_s
from gazemeasure.obstacles.eyes import CORNERS, FRONT, TURN_S, Where
from gazemeasure.obstacles.run import deliver, fastest
from gazemeasure.turn.board import settings_with
from gazesim.chair import Chair
from gazesim.homes import Home
from gazesim.lidar_noise import NOISE_M
from gazesim.rooms import Room
from gazesim.zone import zone_of

MOUNTS = {"two lidars": CORNERS, "one lidar": FRONT}
RAYS = 3200
_STEP_MS = 10
_LOOK_MS = 100
_MISSION_MS = 50
_PEOPLE_MS = 50
_LATE_MS = 10
_PLAN_MS = 300  # time that planning takes at least
_TTL_MS = 150
_FULL = 1000
_NEAR_M = 0.6
_WALK_M_S = 1.2
_MOVING_M_S = 0.05
# The pose as odometry and map give it: Gauss-Markov errors, late.
_POSE_M, _POSE_RAD, _POSE_TAU_S = 0.015, math.radians(0.3), 3.0
_POSE_LATE_MS = 80
_SPEED_M_S, _RATE_DEG_S = 0.02, 0.3
_HEADING_DEG = 0.1


@dataclass
class Outcome:
    """The result of a mission."""

    arrived: bool = False
    reported_arrived: bool = False
    collisions: int = 0
    took_s: float = 0.0
    ideal_s: float = 0.0
    way_m: float = 0.0
    end_m: float = math.inf
    end_deg: float = math.inf
    least_m: float = math.inf
    accelerations: list[float] = field(default_factory=list)
    jerks: list[float] = field(default_factory=list)
    plans: int = 0
    plan_s: list[float] = field(default_factory=list)
    step_ms: list[float] = field(default_factory=list)
    overrides: dict[str, int] = field(default_factory=dict)
    reason: str = ""
    ended: str = ""
    """Why the board ended the press: nothing moves until a person presses again."""
    spent_s: dict[str, float] = field(default_factory=dict)
    """How the time was spent, s by activity."""
    blocked_reported_s: float | None = None


class _Later(Future[Planned]):
    """A plan that is known now, and ready in virtual time."""

    def __init__(self, go: Go, found: Planned, took_s: float) -> None:
        super().__init__()
        self._go, self._ready_ms = go, go.now_ms + max(_PLAN_MS, 1000.0 * took_s)
        self.set_result(found)

    def done(self) -> bool:
        return self._go.now_ms >= self._ready_ms


class Go:
    """One chair in one home."""

    def __init__(
        self,
        room: Room,
        grid: OccupancyGrid,
        start: Pose,
        profile: str = "3.1",
        lidars: str = "two lidars",
        seed: int = 1,
        chair: Chair | None = None,
        no_go: tuple[Any, ...] = (),
    ) -> None:
        self.room = room
        self.seed = seed
        self._random = np.random.default_rng(seed)
        settings = settings_with(
            {
                "profile": PROFILES.index(profile),
                "linear_permille": _FULL,
                "turn_permille": _FULL,
            }
        )
        values = {row[0]: getattr(settings, row[0]) for row in TABLE}
        self.numbers = ChairNumbers.of(values)
        self.chair = chair or Chair(profile, seed)
        self.chair.place(start[0], start[1], math.degrees(start[2]))
        self.chair.step(0.01, (0.0, 0.0))
        self.core: Any = BoardCore(settings)
        self._settings, self._trusted = settings, False
        self._permitted = Stopping(settings, codes.DIR_FORWARD, False).auto
        footprint = Footprint()
        costmap = costmap_of(grid, footprint, no_go)
        self.mission = Mission(
            costmap, Planner(costmap, lidars == "two lidars"), self.numbers, footprint, self._submit
        )
        mounts = MOUNTS[lidars]
        self._eyes = [HalfTurnEye(m, room, NOISE_M, seed + k, RAYS) for k, m in enumerate(mounts)]
        self._blindness = [Blindness() for _ in mounts]
        origins = [(m.pose.x_m, m.pose.y_m) for m in mounts]
        self._evaluate = Evaluator(footprint, origins)
        self._evaluate.zone = zone_of(settings)
        self._clearance: tuple[int, Clearance] | None = None
        self._poses: deque[tuple[float, Located]] = deque(maxlen=60)
        self._error = np.zeros(3)
        self.now_ms = 0
        self._put_out = STOP
        self._farther_m = 0.0
        self._touching = False
        self._before = (0.0, 0.0)
        self.pose_lost = False
        self.jump = np.zeros(3)
        self.outcome = Outcome()
        self._arm()

    @property
    def stick(self) -> Stick:
        """The present request."""
        return Stick(self.core.i.linear_permille, self.core.i.turn_permille)

    # -- the world ---------------------------------------------------------------------------------

    @property
    def pose(self) -> Where:
        """The chair's true pose."""
        return self.chair.x_m, self.chair.y_m, self.chair.heading_deg

    def _arm(self) -> None:
        core = self.core
        core.arm()
        core.lidar = core.imu = False
        for _ in range(6):
            for eye in self._eyes:
                eye.step(0.02, self.pose)
        self._look()
        self._clearance = None
        core.i.clearance_count = (core.i.clearance_count + 1) & 0xFFFF

    def run_ms(self, ms: int) -> None:
        """Run for `ms`, a multiple of 10."""
        for _ in range(ms // _STEP_MS):
            self._step()

    def _step(self) -> None:
        self.now_ms += _STEP_MS
        now_s = self.now_ms / 1000.0
        for eye in self._eyes:
            eye.step(_STEP_MS / 1000.0, self.pose)
        if self.now_ms % _LOOK_MS == 0:
            self._look()
        if self._clearance is not None and self._clearance[0] <= self.now_ms:
            deliver(self.core.i, self._clearance[1], now_s)
            self._clearance = None
        self._sense()
        if self.now_ms % _MISSION_MS == 0:
            self._plan_and_follow(now_s)
        for _ in range(_STEP_MS):
            self.core.tick()
        motion = self.core.motion
        self._put_out = Stick(motion.linear_permille, motion.turn_permille)
        self.chair.step(
            _STEP_MS / 1000.0, (motion.linear_permille / 1000.0, motion.turn_permille / 1000.0)
        )
        self.outcome.way_m += abs(self.chair.speed_m_s) * _STEP_MS / 1000.0
        self._feel()
        if self.now_ms % _PEOPLE_MS == 0:
            if isinstance(self.room, Home):
                self.room.walk(_PEOPLE_MS / 1000.0, *self.pose)
            else:
                self.room.step(_PEOPLE_MS / 1000.0, *self.pose)
        self._judge()

    def _feel(self) -> None:
        if self.now_ms % 50 == 0:  # as a person feels it
            speed, acceleration = self._before
            now = (self.chair.speed_m_s - speed) / 0.05
            self.outcome.accelerations.append(abs(now))
            self.outcome.jerks.append(abs(now - acceleration) / 0.05)
            self._before = (self.chair.speed_m_s, now)

    def _judge(self) -> None:
        speed = fastest(self.chair)
        people = _WALK_M_S if self.room.people else 0.0
        self._farther_m -= _STEP_MS / 1000.0 * (speed + people)
        if self.now_ms % 20 or self._farther_m > _NEAR_M or (speed == 0.0 and not people):
            return
        gap_m = self.room.clearance_m(*self.pose)
        self._farther_m = gap_m
        if speed > _MOVING_M_S:
            self.outcome.least_m = min(self.outcome.least_m, gap_m)
        if gap_m > 0.0:
            self._touching = False
        elif speed > _MOVING_M_S and not self._touching:
            self._touching = True
            self.outcome.collisions += 1

    # -- sensors -----------------------------------------------------------------------------------

    def _look(self) -> None:
        now_s = self.now_ms / 1000.0
        views = tuple(
            to_chair(eye.scan(now_s), eye.mount.pose, eye.mount.mask, blindness)
            for eye, blindness in zip(self._eyes, self._blindness, strict=True)
        )
        found = self._evaluate(views)
        clearance = Clearance(source=codes.SIMULATED, acquired_s=now_s - TURN_S, **found)
        self._clearance = (self.now_ms + _LATE_MS, clearance)
        located = self._located_at(now_s - 0.5 * TURN_S)
        if located is not None and not self.pose_lost:
            points = np.concatenate([view.points_m for view in views])
            counts = [len(view.points_m) for view in views]
            origins = np.repeat([view.origin_m for view in views], counts, axis=0)
            self.mission.scan(points, origins, now_s, located.pose)

    def _sense(self) -> None:
        i = self.core.i
        heading = self.chair.heading_deg + self._random.normal(0.0, _HEADING_DEG)
        i.heading_q4 = round(16.0 * heading) % 5760
        i.rate_q4 = round(16.0 * self.chair.yaw_rate_deg_s)
        i.heading_count = (i.heading_count + 1) & 0xFFFF
        if self.now_ms % _MISSION_MS:
            return
        fade = math.exp(-_MISSION_MS / 1000.0 / _POSE_TAU_S)
        sigmas = np.array((_POSE_M, _POSE_M, _POSE_RAD))
        self._error = fade * self._error + math.sqrt(1.0 - fade**2) * sigmas * (
            self._random.standard_normal(3)
        )
        x, y, turned = np.array((*self.pose[:2], math.radians(self.pose[2])))
        error = self._error + self.jump
        located = Located(
            (float(x + error[0]), float(y + error[1]), float(turned + error[2])),
            self.chair.speed_m_s + float(self._random.normal(0.0, _SPEED_M_S)),
            self.chair.yaw_rate_deg_s + float(self._random.normal(0.0, _RATE_DEG_S)),
            self.now_ms / 1000.0,
        )
        self._poses.append((self.now_ms / 1000.0, located))

    def _located_at(self, at_s: float) -> Located | None:
        old = [one for time_s, one in self._poses if time_s <= at_s + 1e-6]
        return old[-1] if old else None

    # -- the mission -------------------------------------------------------------------------------

    def _plan_and_follow(self, now_s: float) -> None:
        mission = self.mission
        mission.locate(None if self.pose_lost else self._located_at(now_s - _POSE_LATE_MS / 1000.0))
        begin_s = time.process_time()
        stick = mission.step(now_s, self._put_out)
        self.outcome.step_ms.append(1000.0 * (time.process_time() - begin_s))
        self._command(stick)
        self._account(stick)

    def _submit(self, job: Callable[[], Planned]) -> Future[Planned]:
        """Plan at once; the result is ready _PLAN_MS later, or after the time that it took."""
        begin_s = time.process_time()
        found = job()
        took_s = time.process_time() - begin_s
        self.outcome.plan_s.append(took_s)
        return _Later(self, found, took_s)

    def _may(self, trusted: bool) -> Permitted:
        return Permitted(self._settings, self.numbers, trusted)

    def _account(self, stick: Stick) -> None:
        """Record how these 50 ms were spent."""
        self._trusted = self._trusted or self.core.profile_agrees
        override = self.core.safety.override
        if override != codes.NO_REASON:
            name = codes.reason_name(override)
            self.outcome.overrides[name] = self.outcome.overrides.get(name, 0) + 1
        out, requested = abs(self._put_out.linear_permille), abs(stick.linear_permille)
        if override != codes.NO_REASON:
            what = "overruled"
        elif requested:
            slowed = out < 0.95 * min(requested, self._permitted)
            what = "slowed by the board" if slowed else "slower than permitted"
            if out > 0.9 * self._permitted:
                what = "driving"
        elif self.mission.turns_on_spot:
            what = "turning"
        else:
            what = self.mission.state + " " + self.mission.reason
        self.outcome.spent_s[what] = self.outcome.spent_s.get(what, 0.0) + _MISSION_MS / 1000.0

    def _command(self, stick: Stick) -> None:
        """Send the planner's value, with supervision."""
        i, core = self.core.i, self.core
        i.linear_permille, i.turn_permille = stick.linear_permille, stick.turn_permille
        core.command(_TTL_MS)
        core.watch_on()

    def press(self) -> None:
        """A person starts the auto motion with a press."""
        self.core.auto(0, 0, _TTL_MS)
        self.core.hold_ms = 0
        self.core.watched = False
        self.core.watch_on()

    @property
    def ended(self) -> bool:
        """True if the board has ended the press."""
        return bool(self.core.safety.edge != self.core.i.edge)

    def go(self, goal: Pose, limit_s: float, settle_s: float = 1.0) -> Outcome:
        """Drive until it arrives or gives up; at most `limit_s` plus 4 times the ideal time."""
        mission, outcome = self.mission, self.outcome
        begin_ms = self.now_ms
        mission.go(goal)
        self.press()
        self._step()
        first_path: Path | None = None
        began, permitted = _pose_of(self.pose), self._may(False)
        blocked_ms = 0
        while self.now_ms - begin_ms < 1000.0 * (limit_s + 4.0 * outcome.ideal_s):
            self._step()
            if mission.path is not None and first_path is None:
                first_path, began = mission.path, _pose_of(self.pose)
                outcome.ideal_s = ideal_s(first_path, began, permitted)
            if mission.state == ARRIVED:
                break
            if mission.state == BLOCKED:
                if outcome.blocked_reported_s is None:
                    outcome.blocked_reported_s = (self.now_ms - begin_ms) / 1000.0
                blocked_ms += _STEP_MS
                if blocked_ms > 30_000:
                    break
            if self.ended:
                outcome.ended = codes.reason_name(self.core.safety.override)
                break
            if outcome.collisions:
                break
        outcome.took_s = (self.now_ms - begin_ms) / 1000.0
        if self._trusted and first_path is not None:
            outcome.ideal_s = ideal_s(first_path, began, self._may(True))
        outcome.reported_arrived = mission.state == ARRIVED
        outcome.reason = mission.reason or mission.state
        self.run_ms(round(1000.0 * settle_s))
        x, y, heading_deg = self.pose
        outcome.end_m = math.dist((x, y), goal[:2])
        outcome.end_deg = abs(math.remainder(heading_deg - math.degrees(goal[2]), 360.0))
        near = outcome.end_m <= 0.15 and outcome.end_deg <= 5.0
        outcome.arrived = outcome.reported_arrived and near and not outcome.collisions
        outcome.plans = mission.plans
        return outcome


def _pose_of(where: Where) -> Pose:
    return where[0], where[1], math.radians(where[2])
