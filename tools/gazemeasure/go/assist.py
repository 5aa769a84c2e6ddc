"""A door or a cluttered room, driven by a simulated gaze driver with and without assist.

The board's own safety core, motion and obstacle rule decide a thousand times a second, with the
board's default settings; lidars and clearance are those of obstacles/run.py. The same person (same
seed) drives each task three times: without the board's obstacle rule (BARE), with it (PLAIN), and
with assist too (HELPED). A contact is judged by the room's geometry; the run ends with it.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Any

from gazeboard.core.motion import Motion
from gazeboard.turning.turn import turn_controller
from gazechair.assist.assist import Assist
from gazechair.base.footprint import Footprint, Margins
from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.evaluate import Evaluator
from gazechair.sensing.inbox.motion import Motion as Moved
from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import to_chair
from gazelink import codes
from gazelink.settings_table import PROFILES
from gazemeasure.go.assist_routes import route
from gazemeasure.obstacles.eyes import CORNERS, TURN_S, Eye
from gazemeasure.obstacles.run import deliver, fastest
from gazemeasure.turn.board import settings_with
from gazesim import chair as twin
from gazesim.chair import Chair
from gazesim.core_rig import Core
from gazesim.gaze_driver import GazeDriver, Point, Seen
from gazesim.random_rooms import door_task, task
from gazesim.rooms import Room
from gazesim.zone import zone_of

BARE, PLAIN, HELPED = "no rule", "rule only", "with assist"
NARROW = Margins(0.05, 0.0, 0.05)
_WIDE_M = 0.86  # from this width on the usual side margin of 2 cm fits
_STEP_S = 0.01
_PERSON_STEPS = 3  # steps between two ticks of driver and page
_LOOK_STEPS = 5
_RAYS = 3200
_LIMIT_S = 90.0
_FULL = 1000
_SIDES = {"left": 1, "right": -1}


@dataclass(frozen=True)
class Task:
    """A room, its driver's route (shorter with help), and the footprint."""

    name: str
    room: Room
    route: tuple[Point, ...]
    helped_route: tuple[Point, ...]
    margins: Margins


@dataclass
class Outcome:
    """The result of one task."""

    arrived: bool = False
    contact: bool = False
    commands: int = 0
    overrides: int = 0
    """Presses that the board ended."""
    took_s: float = 0.0
    loose: int = 0
    """Steps with an output although no button was held."""


def door(seed: int, width_m: float | None = None, margins: Margins | None = None) -> Task:
    """A door of 0.81-0.90 m; the chair starts 1.5-2.5 m before it, aside and at an angle."""
    chance = random.Random(f"assist door {seed}")
    width = chance.uniform(0.81, 0.90)
    if width_m is not None:
        width = width_m
    aside = chance.uniform(-0.45, 0.45)
    before = chance.uniform(1.5, 2.5)
    room = door_task(width, chance.uniform(0.08, 0.2), 0.0, 0.0, before).room
    heading = chance.uniform(-12.0, 12.0)
    room = Room("door", room.walls, room.furniture, start=(room.start[0], aside, heading))
    goal = (1.3, 0.0)
    front = twin.FRONT_M + 0.35
    return Task(
        "door", room, ((-front - 0.2, 0.0), (0.0, 0.0), goal), (goal,), margins or _fitting(width)
    )


def _fitting(width_m: float) -> Margins:
    # The side margin that the door allows for: see docs/assist.md.
    return Margins() if width_m >= _WIDE_M else NARROW


def cluttered(seed: int) -> Task:
    """A room full of furniture, with a route that keeps a hand's breadth from everything."""
    number = 1000 * seed
    while True:
        room = task("room", number).room
        found = route(room, (room.start[0], room.start[1]))
        if found:
            return Task("room", room, found, found, Margins())
        number += 1


class Run:
    """One task in one of three ways."""

    def __init__(self, task: Task, way: str, seed: int, profile: str) -> None:
        self._room = task.room
        self.chair = Chair(profile, seed)
        self.chair.place(*task.room.start)
        self.core: Any = Core()
        core = self.core
        core.settings = settings_with({"profile": PROFILES.index(profile)})
        core.obstacles.configure(core.settings)
        core.motion = core._tick.motion = Motion(core.settings, turn_controller(core.settings))
        core.lidar = core.imu = False
        core.trusted = bool(seed % 2)
        self._eyes = [Eye(m, self._room, 0.006, seed + k, _RAYS) for k, m in enumerate(CORNERS)]
        footprint = Footprint(margins=task.margins)
        zone = zone_of(core.settings)
        self._evaluate = Evaluator(footprint, [(m.pose.x_m, m.pose.y_m) for m in CORNERS])
        self._evaluate.zone = zone
        self._blindness = [Blindness() for _ in self._eyes]
        self._ruled = way != BARE
        self._assist: Assist | None = None
        if way == HELPED:
            self._assist = Assist(footprint, len(self._eyes))
            self._assist.permits.zone = zone
        self._clearance: Clearance | None = None
        self._advice: Any = None
        self._next_advice: Any = None
        self._steps = 0
        self._press = 0
        self._turns = 0
        self._held: str | None = None
        route = task.helped_route if way == HELPED else task.route
        self.person = GazeDriver(seed, route, way == HELPED)
        self._turn_deg_s = 0.5 * self.chair.parameters.turn.positive * 0.9
        self._free_m = 0.0
        self.outcome = Outcome()

    def __call__(self) -> Outcome:
        """Run it to its end."""
        core = self.core
        for _ in range(80):
            self._step()
        for _ in range(100):
            if core.safety.arm_reason == codes.NO_REASON:
                break
            self._step()
        core.order(codes.ARM)
        for _ in range(20):
            self._step()
        assert core.armed(), core.why()
        begun = self._steps
        while not self.outcome.contact and (self._steps - begun) * _STEP_S < _LIMIT_S:
            if self._steps % _PERSON_STEPS == 0:
                self._person()
            self._step()
            if self.person.arrived:
                self.outcome.arrived = True
                break
        self.outcome.commands = self.person.commands
        self.outcome.took_s = (self._steps - begun) * _STEP_S
        return self.outcome

    def _person(self) -> None:
        now_s = self._steps * _STEP_S
        chair, core = self.chair, self.core
        before = self.person.commands
        waits = self._advice is not None and self._advice.waits
        pose = chair.x_m, chair.y_m, chair.heading_deg
        held = self.person.tick(now_s, Seen(*pose, core.moving(), self._turn_deg_s, waits))
        if held is None:
            if self._held is not None:
                core.release()
        elif self.person.commands != before:
            self._press += 1
            self._advice = None
            core.release()
            core.tick()
            verb = codes.VERBS.index(held)
            self._turns = _SIDES.get(held, 0)
            if held == "forward" and self._assist is not None:
                verb = codes.DRIVE
                core.i.linear_permille, core.i.turn_permille = 0, 0
            core.press(verb)
        self._held = held

    def _step(self) -> None:
        self._steps += 1
        now_s = self._steps * _STEP_S
        chair, core = self.chair, self.core
        self._sense(now_s)
        core.i.rate_q4 = round(16.0 * chair.yaw_rate_deg_s)
        core.i.heading_q4 = round(16.0 * chair.heading_deg) % 5760
        core.i.heading_count = (core.i.heading_count + 1) & 0xFFFF
        edge = core.i.edge if core.hold_ms else 0
        for _ in range(10):
            core.tick()
        if edge and core.safety.spent_edge == edge and core.safety.edge == 0:
            self.outcome.overrides += 1
            core.release()
            self.person.ended()
        out = core.motion.linear_permille, core.motion.turn_permille
        self.outcome.loose += self._held is None and out != (0, 0)
        chair.step(_STEP_S, (out[0] / 1000.0, out[1] / 1000.0))
        self._check()

    def _sense(self, now_s: float) -> None:
        chair, core = self.chair, self.core
        if not self._ruled:
            core.i.clearance_count = (core.i.clearance_count + 1) & 0xFFFF
            core.i.clearance_age_ms = 20
            return
        where = (chair.x_m, chair.y_m, chair.heading_deg)
        for eye in self._eyes:
            eye.step(_STEP_S, where)
        if self._clearance is not None:
            deliver(core.i, self._clearance, now_s)
            if self._assist is not None:
                self._assist.permits.clearance = self._clearance
            self._clearance = None
        if self._steps % _LOOK_STEPS == 0 and self._eyes[0].turns:
            views = tuple(
                to_chair(eye.scan(now_s), eye.mount.pose, eye.mount.mask, blindness)
                for eye, blindness in zip(self._eyes, self._blindness, strict=True)
            )
            found = self._evaluate(views)
            self._clearance = Clearance(source=codes.REAL, acquired_s=now_s - TURN_S, **found)
        if self._assist is not None:
            self._help(now_s)

    def _help(self, now_s: float) -> None:
        assist, core = self._assist, self.core
        assert assist is not None
        if self._steps % 2 == 0:
            heading = round(16.0 * self.chair.heading_deg) / 16.0 % 360.0
            out = core.motion.linear_permille, core.motion.turn_permille
            assist.motion(Moved(now_s, heading, *out))
        if self._steps % _LOOK_STEPS == 0:
            for at, eye in enumerate(self._eyes):
                assist.see(at, eye.half_turn(now_s))
            if self._turns:  # seen at least once, even if the board ended it at once
                assist.driver_turns(self._turns, now_s)
                self._turns = _SIDES.get(self._held or "", 0)
            if self._next_advice is not None and self._held == "forward":
                press, advice = self._next_advice
                if press == self._press and core.i.verb == codes.DRIVE:
                    self._advice = advice
                    linear, turn = _FULL, 0
                    if advice is not None:
                        linear, turn = advice.linear_permille, advice.turn_permille
                    core.i.linear_permille, core.i.turn_permille = linear, turn
            self._next_advice = None
            if self._held == "forward":
                self._next_advice = self._press, assist.advise(self._press, now_s)

    def _check(self) -> None:
        chair = self.chair
        speed = fastest(chair)
        self._free_m -= _STEP_S * speed
        if self._free_m > 0.0 or speed == 0.0:
            return
        gap_m = self._room.clearance_m(chair.x_m, chair.y_m, chair.heading_deg)
        self._free_m = 0.9 * gap_m
        if gap_m <= 0.0:
            self.outcome.contact = True
