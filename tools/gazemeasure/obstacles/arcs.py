"""Measures driving by a proportional stick past posts, walls and furniture: both axes at once.

A run is an ArcTask: a room and the motion of the driver's hand. The board's own modules decide
(what obstacles permit, and the resulting output) a thousand times a second; chair, lidars and the
definition of a collision are those of run.py. Without the rule the same hand drives on, to
find out whether the path was passable.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from gazeboard.core.directions import ARC_BLOCKED
from gazeboard.core.motion import Motion
from gazeboard.core.obstacles import Obstacles
from gazeboard.core.shared import Inputs
from gazeboard.turning.turn import turn_controller
from gazechair.board.board_commands import Clearance
from gazelink import codes
from gazelink.settings_table import PROFILES
from gazemeasure.obstacles.attack import Hold, attack, attacked_chair, in_view, touched
from gazemeasure.obstacles.eyes import CORNERS, FRONT, Eye, Ours
from gazemeasure.obstacles.run import (
    FULL,
    LOOK_STEPS,
    MOVING_M_S,
    NEAR_M,
    STEP_S,
    Outcome,
    deliver,
    fastest,
)
from gazemeasure.turn.board import settings_with
from gazesim.chair import FRONT_M, HALF_WIDTH_M, REAR_M, Chair
from gazesim.lidar_noise import NOISE_M
from gazesim.random_rooms import task
from gazesim.rooms import Room, Solid, box

_BEGIN_STEPS = 60  # the lidars' first turns, and the board's first look
_REST_S = 4.0
_AGAIN_S = 0.5  # after an override: until the next press
_BEYOND_S = 1.5
_HALL_M = 4.0
_IN_A_ROW = 20  # arcs, then attacks


class Body(Protocol):
    """A chair of some physics; as gazesim.chair.Chair."""

    x_m: float
    y_m: float
    heading_deg: float
    speed_m_s: float
    yaw_rate_deg_s: float

    def place(self, x_m: float, y_m: float, heading_deg: float) -> None: ...
    def step(self, dt_s: float, stick: tuple[float, float] | None) -> None: ...


@dataclass(frozen=True)
class ArcTask:
    """A room and the hand's motion. `steady`: one stick position, whose path is judged."""

    room: Room
    hand: tuple[Hold, ...]
    steady: bool


def _arc_task(seed: int) -> ArcTask:
    """The task with that seed: every other one steady."""
    chance = random.Random(f"arc {seed}")
    room = _posts(chance) if chance.random() < 0.6 else task("room", seed).room
    if seed % 2:
        hold = Hold(chance.uniform(0.8, 3.0), codes.DRIVE, *_stick(chance), press=True)
        return ArcTask(room, (hold,), True)
    hand = []
    linear, turn = _stick(chance)
    for n in range(chance.randint(3, 8)):
        what = chance.random()
        verb = codes.DRIVE
        if what < 0.25:
            turn = -turn
        elif what < 0.35:
            linear = -linear
        elif what < 0.45:
            linear, turn = -linear, -turn
        elif what < 0.55:
            linear, turn = (linear, 0) if chance.random() < 0.5 else (0, turn)
        elif what < 0.65:
            verb = chance.choice((codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT))
        else:
            linear, turn = _stick(chance)
        press = n == 0 or verb != codes.DRIVE or chance.random() < 0.2
        hand.append(Hold(chance.choice((0.1, 0.3, 0.8, 1.6)), verb, linear, turn, press))
    return ArcTask(room, tuple(hand), False)


def _stick(chance: random.Random) -> tuple[int, int]:
    angle = chance.uniform(-math.pi, math.pi)
    size = chance.choice((300, 600, 1000, 1400))
    linear, turn = (round(size * part(angle)) for part in (math.cos, math.sin))
    return max(-FULL, min(FULL, linear)), max(-FULL, min(FULL, turn))


def _posts(chance: random.Random) -> Room:
    """A room with posts at the chair's sides and ahead, and a wall or two."""
    h = _HALL_M
    walls = [(-h, -h, h, -h), (h, -h, h, h), (h, h, -h, h), (-h, h, -h, -h)]
    for side in (1, -1):
        if chance.random() < 0.3:
            y = side * (HALF_WIDTH_M + chance.uniform(0.08, 0.8))
            x = chance.uniform(-1.5, 1.0)
            walls.append((x, y, x + chance.uniform(0.3, 3.0), y))
    things: list[Solid] = []
    for _ in range(chance.randint(1, 4)):
        size = chance.uniform(0.04, 0.15)
        if chance.random() < 0.6:  # at a side
            y = chance.choice((1, -1)) * (HALF_WIDTH_M + chance.uniform(0.05, 0.5) + size / 2)
            x = chance.uniform(REAR_M - 0.4, FRONT_M + 0.8)
        else:  # ahead, behind
            ahead = chance.uniform(0.15, 1.5) + size / 2
            x = FRONT_M + ahead if chance.random() < 0.7 else REAR_M - ahead
            y = chance.uniform(-0.6, 0.6)
        things.append(box(x, y, size, size, 0.0, 1.0, "wood", chance.uniform(0, 90)))
    return Room("posts", tuple(walls), tuple(things), start=(0.0, 0.0, 0.0))


class ArcRun:
    """One run of `wanted`: with the rule, or without (`ruled` False)."""

    def __init__(
        self,
        wanted: ArcTask,
        profile: str,
        seed: int,
        ruled: bool = True,
        body: Body | None = None,
        one_lidar: bool = False,
    ) -> None:
        self._task = wanted
        self._room = wanted.room
        self.chair: Any = body or Chair(profile, seed)
        self.chair.place(*wanted.room.start)
        self.chair.step(STEP_S, (0.0, 0.0))
        numbers = {"linear_permille": FULL, "turn_permille": FULL}
        made = settings_with({"profile": PROFILES.index(profile), **numbers})
        self._inputs: Any = Inputs()
        self._inputs.cap_permille = FULL
        self._obstacles: Any = Obstacles(made)
        self._motion: Any = Motion(made, turn_controller(made))
        self._trusted = bool(seed // 2 % 2)
        mounts = FRONT if one_lidar else CORNERS
        self._eyes = [Eye(m, self._room, NOISE_M, seed + k) for k, m in enumerate(mounts)]
        self._rule = Ours(self._eyes) if ruled else None
        self._clearance: Clearance | None = None
        self._out = (0, 0)
        self._steps = 0
        self._pressed = False
        self._farther_m = 0.0
        self.outcome = Outcome()
        self.least: tuple[float, ...] = ()
        """Least distance, and the pose there."""

    def __call__(self, watch: Callable[[ArcRun], None] | None = None) -> Outcome:
        """Run it to its end; `watch` is called with each step of 10 ms."""
        for _ in range(_BEGIN_STEPS):
            self._step()
        for hold in self._task.hand:
            if hold.press:
                self._command(codes.STOP)
                self._step()
            self._command(hold.verb, hold.linear, hold.turn, hold.press)
            for _ in range(round(hold.for_s / STEP_S)):
                self._step()
                if watch is not None:
                    watch(self)
                if self.outcome.touched:
                    return self.outcome
                if self._rule is not None and not self._pressed:
                    self.outcome.stopped = True
                    break
            if not self._pressed and self._rule is not None:
                self._pause(watch)
                if self._task.steady or self.outcome.touched:
                    return self.outcome
        self.outcome.arrived = True
        if self._rule is None and self._task.steady:
            for _ in range(round(_BEYOND_S / STEP_S)):
                self._step()
        self._command(codes.STOP)
        left = round(_REST_S / STEP_S)
        while left and fastest(self.chair) > 0.0 and not self.outcome.touched:
            self._step()
            left -= 1
        return self.outcome

    def _pause(self, watch: Callable[[ArcRun], None] | None) -> None:
        # The stick is held for a moment, then released.
        for k in range(round(2 * _AGAIN_S / STEP_S)):
            if k == round(_AGAIN_S / STEP_S):
                self._command(codes.STOP)
            self._step()
            if watch is not None:
                watch(self)
            if self.outcome.touched:
                return

    def _command(self, verb: int, linear: int = 0, turn: int = 0, press: bool = True) -> None:
        i = self._inputs
        i.verb, i.mode = verb, codes.CONTINUOUS
        i.linear_permille, i.turn_permille = linear, turn
        if press:
            i.edge = i.edge % 255 + 1
            self._pressed = verb != codes.STOP

    def _step(self) -> None:
        self._steps += 1
        now_s = self._steps * STEP_S
        chair = self.chair
        if self._rule is not None:
            where = (chair.x_m, chair.y_m, chair.heading_deg)
            for eye in self._eyes:
                eye.step(STEP_S, where)
            if self._clearance is not None:
                deliver(self._inputs, self._clearance, now_s)
                self._clearance = None
            if self._steps % LOOK_STEPS == 0 and self._eyes[0].turns:
                self._clearance = self._rule.look(now_s)
        self._inputs.rate_q4 = round(16.0 * chair.yaw_rate_deg_s)
        self._inputs.heading_q4 = round(16.0 * chair.heading_deg) % 5760
        self._inputs.heading_count = (self._inputs.heading_count + 1) & 0xFFFF
        for _ in range(10):
            self._tick()
        chair.step(STEP_S, (self._out[0] / 1000.0, self._out[1] / 1000.0))
        self._check()

    def _tick(self) -> None:
        i, obstacles, motion = self._inputs, self._obstacles, self._motion
        blocked = 0
        caps = [FULL] * 4
        arcs = None
        if self._rule is not None:
            obstacles.step(i, *self._out, True, self._trusted)
            blocked, caps, arcs = obstacles.blocked, obstacles.caps, obstacles.arcs
        if self._pressed and blocked & (ARC_BLOCKED | self._requested()):
            self._pressed = False
        if self._pressed and i.verb != codes.STOP:
            motion.step(i, blocked, caps, 0, arcs)
        else:
            motion.stop()
        self._out = (motion.linear_permille, motion.turn_permille)

    def _requested(self) -> int:
        i = self._inputs
        if i.verb != codes.DRIVE:
            return int(1 << (i.verb - codes.FORWARD))
        along = (i.linear_permille > 0) << codes.DIR_FORWARD
        along |= (i.linear_permille < 0) << codes.DIR_BACKWARD
        aside = (i.turn_permille > 0) << codes.DIR_LEFT
        return int(along | aside | (i.turn_permille < 0) << codes.DIR_RIGHT)

    def _check(self) -> None:
        chair = self.chair
        speed = fastest(chair)
        self._farther_m -= STEP_S * speed
        if self._farther_m > NEAR_M or speed == 0.0:
            return
        gap_m = self._room.clearance_m(chair.x_m, chair.y_m, chair.heading_deg)
        self._farther_m = gap_m
        if speed > MOVING_M_S and gap_m < self.outcome.least_m:
            self.outcome.least_m = gap_m
            self.least = (gap_m, chair.x_m, chair.y_m, chair.heading_deg, speed)
        if gap_m <= 0.0:
            if not self.outcome.touched:
                self.outcome.contact_m_s = speed
            self.outcome.touched = True
            self.outcome.collided |= speed > MOVING_M_S


@dataclass(frozen=True)
class ArcTrial:
    """One arc with the rule, and without any where the path is steady."""

    profile: str
    ours: Outcome
    free: Outcome | None
    attack: str = ""
    """Physics of attack.py, or ""."""
    unseen_m_s: float = 0.0
    """Speed at which it touched what no lidar sees of an object; no collision of the rule."""

    @property
    def passable(self) -> bool:
        """True if the same hand without the rule keeps 5 cm, for 1.5 s longer."""
        return self.free is not None and self.free.arrived and self.free.least_m >= 0.05


def arc_trial(seed: int) -> ArcTrial:
    """The arc with that seed; every eighth with one lidar in front, every other twenty attacks."""
    profile = PROFILES[seed // 4 % len(PROFILES)]
    if seed // _IN_A_ROW % 2:
        return attack_trial(seed, profile)
    wanted = _arc_task(seed)
    run = ArcRun(wanted, profile, seed, one_lidar=seed % 8 == 7)
    ours = run()
    unseen_m_s = _unseen_m_s(run, touched(wanted.room, run.chair), seed)
    free = ArcRun(wanted, profile, seed, ruled=False)() if wanted.steady else None
    return ArcTrial(profile, ours, free, unseen_m_s=unseen_m_s)


def attack_trial(seed: int, profile: str) -> ArcTrial:
    """The attack with that seed; its hand hits without the rule."""
    settings = settings_with({"profile": PROFILES.index(profile)})
    what = attack(seed, profile, settings)
    chair = attacked_chair(seed, profile, settings)
    wanted = ArcTask(what.room, what.hand, bool(seed % 2))
    run = ArcRun(wanted, profile, seed, body=chair, one_lidar=seed % 8 == 7)
    ours = run()
    unseen_m_s = _unseen_m_s(run, touched(what.room, run.chair), seed)
    return ArcTrial(profile, ours, None, what.kind, unseen_m_s)


def _unseen_m_s(run: ArcRun, points: tuple[tuple[float, float], ...], seed: int) -> float:
    """Speed at which it touched these points, which no lidar sees, else 0; then no collision."""
    mounts = FRONT if seed % 8 == 7 else CORNERS
    if not (run.outcome.touched and points) or in_view(mounts, run.chair, points):
        return 0.0
    run.outcome.collided = False
    return run.outcome.contact_m_s
