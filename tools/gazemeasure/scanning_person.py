"""Simulated people who drive through a door in the benchmark `scanning`: by switch, by gaze.

The switch: a scan time of 1.5 s suits a person whose presses come 0.65 of it after the light, and
it is about their mean plus two standard deviations (Simpson, Koester, LoPresti: Selecting an
appropriate scan rate: the ".65 rule", Assistive Technology 19(2), 2007, doi
10.1080/10400435.2007.10131865): mean 0.975 s, standard deviation 0.26 s. So one press in forty
comes too late and takes the next choice, which the person then undoes. The same times apply to
letting go. Gaze: an estimate, 0.2 s for the eyes to start and 0.15 s to decide.
Driving forward, both know their own delay and the chair's, and let go that much earlier. They plan
how long to hold a turn, with a standard deviation of 15 % (an estimate).
"""

from __future__ import annotations

import math
import random
from typing import Protocol

from gazesim import chair as twin

SCAN_S = 1.5
PRESS_S, PRESS_SD_S = 0.65 * SCAN_S, 0.35 * SCAN_S / 2
_LOOK_S, _LOOK_SD_S = 0.35, 0.1
_LEAVE_S = 0.2  # grace after looking away
_COAST_S = 0.2  # the chair's own delay
_TURN_DEG_S, _TURN_SD, _SHORTEST_S = 9.5, 0.15, 0.35  # a held turn, as learnt
_TAP_S = 0.25
_NOTHING_S, _AWAY_S = 1.5, 0.8  # after a look that fills no ring: look away this long, then again
_APPROACH_DEG = 20.0
_ON_AXIS_M = 0.02
_LAST_STEP_M = 0.08
_STEP_TOLERANCE_DEG = 5.0  # half a step's turn
_OFF_AXIS_M = 0.05
_STRAIGHT_M = 0.4  # nearer to the door they aim at its centre instead of crossing its axis
_BEYOND_M = 0.5  # behind the wall, where they look
_STUCK_S = 1.0  # they let go of a motion without effect for this long

Event = list[str | None]


class Pose(Protocol):
    """The chair's pose and motion."""

    x_m: float
    y_m: float
    heading_deg: float
    speed_m_s: float
    yaw_rate_deg_s: float


class Way:
    """What to do next: to the door's axis at 20 degrees, then towards the door's centre.

    With steps, the last one to the axis at 10 degrees: at 20 it would end on the other side.

    When the chair has stopped in front of the door, they let go, turn a little and continue.
    """

    def __init__(self, wall_m: float, tolerance_deg: float) -> None:
        """`tolerance_deg`: a smaller heading error is not corrected."""
        self._wall_m = wall_m
        self._tolerance_deg = tolerance_deg
        self._steps = tolerance_deg >= _STEP_TOLERANCE_DEG
        self._side = 0.0  # of the axis, while on the way to it
        self._pose: Pose | None = None
        self._stuck = False

    def see(self, pose: Pose) -> None:
        """Take the chair's pose."""
        self._pose = pose

    def stands(self) -> None:
        """Driving forward has no effect."""
        self._stuck = True

    def turns(self) -> None:
        """A turn has begun."""
        self._stuck = False

    @property
    def turn_deg(self) -> float:
        """How far to turn, left positive."""
        assert self._pose is not None
        if self._side:
            last = self._steps and abs(self._pose.y_m) < _LAST_STEP_M
            towards_deg = _APPROACH_DEG / 2 if last else _APPROACH_DEG
            return -towards_deg * self._side - self._pose.heading_deg
        ahead_m = max(_BEYOND_M, _BEYOND_M - self._pose.x_m)
        return math.degrees(math.atan2(-self._pose.y_m, ahead_m)) - self._pose.heading_deg

    def wanted(self, moving: str | None, lead_s: float) -> str | None:
        """The motion wanted `lead_s` from now, None for none; `moving`: the present one."""
        if moving in ("left", "right"):
            return moving
        if moving == "forward" and self._stuck:
            return None
        pose = self._pose
        assert pose is not None
        sine = math.sin(math.radians(pose.heading_deg))
        aside_m = pose.y_m + pose.speed_m_s * lead_s * sine
        before_m = -self._wall_m / 2 - twin.FRONT_M - pose.x_m
        if self._side and (aside_m * self._side < _ON_AXIS_M or before_m < _STRAIGHT_M):
            self._side = 0.0
            if moving == "forward":
                return None
        elif not self._side and abs(aside_m) > _OFF_AXIS_M and before_m > 2 * _STRAIGHT_M:
            self._side = math.copysign(1.0, aside_m)
        if moving or (abs(self.turn_deg) <= self._tolerance_deg and not self._stuck):
            return "forward"
        return "left" if self.turn_deg > 0 else "right"


class Person:
    """A person with a device; times are seconds since the start."""

    mean_s, sd_s, more_s = 0.0, 0.0, 0.0

    def __init__(self, seed: int, holds: bool) -> None:
        """`holds`: drives while holding; else by steps."""
        self._random = random.Random(seed)
        self._holds = self._leads = holds
        self.presses = 0
        self._moving: str | None = None  # the motion that the person began
        self._edge = 0
        self._since_s = 0.0  # it has not moved
        self._moved = False  # by this press
        self._until_s = 0.0  # planned end of the present turn

    def tick(self, now_s: float, way: Way, moves: bool) -> list[Event]:
        """The events of this moment; `moves`: the page shows that the chair moves."""
        raise NotImplementedError

    def sees(self, lit: list[str]) -> None:
        """Take the lit targets."""

    def receives(self, what: str, edge: int, now_s: float, way: Way) -> None:
        """Take the page's command: the person hears its tone and sees it."""
        if what == "stop":
            self._moving = None
        elif edge > self._edge:
            self._edge, self._moving = edge, what
            self._since_s, self._moved = now_s, False
            if what in ("left", "right"):
                way.turns()
            wrong = (what == "left") != (way.turn_deg > 0)
            hold_s = 0.0 if wrong else abs(way.turn_deg) / _TURN_DEG_S
            self._until_s = now_s + max(_SHORTEST_S, hold_s * self._random.gauss(1.0, _TURN_SD))

    def _wanted(self, way: Way) -> str | None:
        # Let a step end: the next one is decided from the pose after it.
        lead_s = self.mean_s + self.more_s + _COAST_S if self._leads else 0.0
        return way.wanted(self._moving, lead_s)

    def _turned(self, now_s: float) -> bool:
        """True if a held turn has lasted as long as planned."""
        turns = self._holds and self._moving in ("left", "right")
        return turns and now_s >= self._until_s - self.more_s

    def _delay_s(self) -> float:
        return max(0.15, self._random.gauss(self.mean_s, self.sd_s))

    def _watch(self, now_s: float, way: Way, moves: bool) -> None:
        # A step ends by itself: the chair has moved and stands again, or never began to move.
        if moves:
            self._since_s, self._moved = now_s, True
        elif self._holds and self._moving == "forward" and now_s - self._since_s > _STUCK_S:
            way.stands()
        elif self._moving and not self._holds and now_s - self._since_s > 0.5:
            if self._moving == "forward" and not self._moved:
                way.stands()
            self._moving = None


class Switcher(Person):
    """Presses the space bar when the wanted target is lit."""

    mean_s, sd_s, more_s = PRESS_S, PRESS_SD_S, 0.04

    def __init__(self, seed: int, holds: bool) -> None:
        super().__init__(seed, holds)
        self._lit: list[str] = []
        self._fresh = False  # newly lit, not considered yet
        self._press_s: float | None = None
        self._release_s: float | None = None
        self._down = False

    def sees(self, lit: list[str]) -> None:
        """A newly lit target is a new chance."""
        self._fresh = self._fresh or lit != self._lit
        self._lit = lit

    def tick(self, now_s: float, way: Way, moves: bool) -> list[Event]:
        """Press or release."""
        self._watch(now_s, way, moves)
        if self._down:
            if self._turned(now_s):
                self._release_s = now_s
            elif self._release_s is None and self._held_enough(way):
                self._release_s = now_s + self._delay_s()
            if self._release_s is None or now_s < self._release_s:
                return []
            self._down, self._release_s = False, None
            return [["keyup", None]]
        if self._press_s is None and self._decides(way, moves):
            self._press_s = now_s + self._delay_s()
        if self._press_s is None or now_s < self._press_s:
            return []
        self._press_s, self._down = None, True
        self._since_s = now_s
        self.presses += 1
        one = len(self._lit) == 1 and self._lit != ["stop"]
        self._release_s = None if one and self._holds else now_s + _TAP_S
        return [["keydown", None]]

    def _held_enough(self, way: Way) -> bool:
        return self._moving is not None and self._wanted(way) != self._moving

    def _decides(self, way: Way, moves: bool) -> bool:
        if self._moving:  # a step ends by itself before a press would
            return False
        fresh, self._fresh = self._fresh, False
        return fresh and not moves and self._wanted(way) in self._lit


class Gazer(Person):
    """Looks at the wanted target."""

    mean_s, sd_s, more_s = _LOOK_S, _LOOK_SD_S, _LEAVE_S

    def __init__(self, seed: int, holds: bool) -> None:
        super().__init__(seed, holds)
        self._leads = True  # quick enough to end a step, too
        self._target: str | None = None  # looked at
        self._next: tuple[float, str | None] | None = None
        self._looked_s = self._away_s = 0.0

    def receives(self, what: str, edge: int, now_s: float, way: Way) -> None:
        """A dwell is a press."""
        self.presses += edge > self._edge
        super().receives(what, edge, now_s, way)

    def tick(self, now_s: float, way: Way, moves: bool) -> list[Event]:
        """Look at the wanted target."""
        self._watch(now_s, way, moves)
        goal = self._goal(way, moves)
        if self._turned(now_s):
            self._next = now_s, None
        if self._target and self._moving is None and now_s - self._looked_s > _NOTHING_S:
            self._looked_s, self._away_s = now_s, now_s + _AWAY_S
        if now_s < self._away_s:
            goal = None
        if goal != self._target and self._next is None:
            self._next = now_s + self._delay_s(), goal
        if self._next is not None and now_s >= self._next[0]:
            self._target, self._next = self._next[1], None
            self._looked_s = now_s
        return [["look", self._target]]

    def _goal(self, way: Way, moves: bool) -> str | None:
        wanted = self._wanted(way)
        if self._moving is None:
            return None if moves else wanted
        if self._holds:
            return wanted
        return "stop" if self._moving == "forward" and wanted != "forward" else None
