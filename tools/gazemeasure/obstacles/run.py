"""One run past obstacles in virtual time: the chair's twin, rays, the board's decision, a driver.

The board's module is stepped a thousand times a second, the chair a hundred times, the mirror
fifty; the clearance is renewed twenty times and reaches the board 10 ms later (the real host: forty
times).
"""

from __future__ import annotations

import copy
import math
from dataclasses import dataclass

from gazeboard.core.obstacles import Obstacles
from gazeboard.core.shared import Inputs
from gazechair.board.board_commands import Clearance
from gazelink import codes
from gazelink.settings_table import PROFILES
from gazemeasure.obstacles.eyes import CORNERS, FRONT, RAYS, Eye, Ours, Prototype
from gazemeasure.turn.board import settings_with
from gazesim import chair as twin
from gazesim.chair import Chair
from gazesim.profiles import undisturbed
from gazesim.random_rooms import WALKER_RADIUS_M, Task
from gazesim.rooms import Person, Room

OURS, PROTOTYPE, NONE = "footprint", "prototype", "none"
MOVING_M_S = 0.05
STEP_S = 0.01
LOOK_STEPS = 5  # from one clearance to the next
_CHECK_STEPS = 2
NEAR_M = 0.6  # a larger distance is not measured exactly
_WALKER_M_S = 1.0
_PRESSES = 3
_PAUSE_S = 0.5
FULL = 1000  # permille
_LIMIT_S = 60.0
_CORNER_M = math.hypot(twin.FRONT_M, twin.HALF_WIDTH_M)
_VERBS = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT)


@dataclass
class Outcome:
    """The result of a run."""

    collided: bool = False
    """Contact while any part of the chair moves faster than 0.05 m/s."""
    touched: bool = False
    """Contact at all."""
    contact_m_s: float = 0.0
    """Speed of the fastest part at the first contact."""
    stopped: bool = False
    """The rule ended a press."""
    arrived: bool = False
    least_m: float = math.inf
    """Smallest true distance to anything while it moved, exact below 0.6 m."""
    took_s: float = 0.0
    met: bool = False
    """A scan has found the walker inside the sweep while the chair moved."""
    stoppable: bool = False
    """Braking at the first such scan would have sufficed."""


class Run:
    """`rule`: OURS, PROTOTYPE or NONE (the driver alone: shows what the path would be)."""

    def __init__(
        self,
        task: Task,
        profile: str,
        rule: str,
        seed: int,
        noise_m: float = 0.006,
        rays: int = RAYS,
        straight: bool = False,
    ) -> None:
        """`straight`: the floor is even, so that the path is as the task requires."""
        self._task = task
        self._room = task.room
        self._chair = Chair(profile, seed, undisturbed(profile) if straight else None)
        self._chair.place(*task.room.start)
        self._chair.step(STEP_S, (0.0, 0.0))
        self._inputs = Inputs()
        settings = settings_with(
            {
                "profile": PROFILES.index(profile),
                "linear_permille": FULL,
                "turn_permille": FULL,
            }
        )
        self._obstacles = Obstacles(settings)
        self._trusted = bool(
            seed % 2
        )  # the board has seen a turn at the profile's rate, or not yet
        self._direction = _VERBS.index(task.verb)
        mounts = FRONT if rule == PROTOTYPE or task.verb == codes.FORWARD else CORNERS
        self._eyes = [Eye(m, self._room, noise_m, seed + k, rays) for k, m in enumerate(mounts)]
        self._rule = None
        if rule != NONE:
            self._rule = Ours(self._eyes) if rule == OURS else Prototype(self._eyes[0])
        self._clearance: Clearance | None = None
        self._out = (0, 0)
        self._now_s = 0.0
        self._walker: Person | None = None
        if task.walker is not None:
            self._walker = Person((task.walker.at(0.0),), radius_m=WALKER_RADIUS_M)
            self._room.people = (self._walker,)
        self._judged = task.walker is None
        self._farther_m = 0.0  # a lower bound of the distance to everything
        self.outcome = Outcome()

    def __call__(self) -> Outcome:
        """Run it to its end."""
        for _ in range(60):  # the lidar's first turns, and the board's first look
            self._look_around()
            self._decide(False)
        presses, pressed, pause_s = 1, True, 0.0
        start = self._chair.x_m, self._chair.y_m, self._chair.heading_deg
        start_s = self._now_s
        while self._now_s < _LIMIT_S and not self.outcome.touched:
            self._look_around()
            self._inputs.rate_q4 = round(16.0 * self._chair.yaw_rate_deg_s)
            blocked = self._decide(pressed)
            if pressed and blocked:
                self.outcome.stopped = True
                pressed, pause_s = False, 0.0
            self._chair.step(STEP_S, (self._out[0] / 1000.0, self._out[1] / 1000.0))
            self._check()
            if pressed and self._way(start) >= self._task.goal:
                self.outcome.arrived = True
                self.outcome.took_s = self._now_s - start_s
                pressed, presses = False, _PRESSES
            if not pressed and self._stands():
                pause_s += STEP_S
                if presses == _PRESSES or (pause_s > _PAUSE_S and blocked):
                    break
                if pause_s > _PAUSE_S:
                    presses, pressed = presses + 1, True
        return self.outcome

    # -- the parts, in the order of a step ---------------------------------------------------------

    def _look_around(self) -> None:
        self._now_s += STEP_S
        if self._walker is not None and self._task.walker is not None:
            self._walker.x_m, self._walker.y_m = self._task.walker.at(self._now_s)
        if self._rule is None:
            return
        where = (self._chair.x_m, self._chair.y_m, self._chair.heading_deg)
        for eye in self._eyes:
            eye.step(STEP_S, where)
        if self._clearance is not None:
            deliver(self._inputs, self._clearance, self._now_s)
            self._clearance = None
        if round(self._now_s / STEP_S) % LOOK_STEPS == 0 and self._eyes[0].turns:
            self._clearance = self._rule.look(self._now_s)

    def _decide(self, pressed: bool) -> bool:
        """Ten ticks of the board; True when it blocks the motion."""
        out = FULL if pressed else 0
        if self._rule is None:
            self._put_out(out)
            return False
        blocked = False
        for _ in range(10):
            self._obstacles.step(self._inputs, *self._out, True, self._trusted)
            blocked = bool(self._obstacles.blocked & (1 << self._direction))
            out = 0 if blocked or out == 0 else min(FULL, self._obstacles.caps[self._direction])
            self._put_out(out)
        return blocked

    def _put_out(self, permille: int) -> None:
        signed = permille if self._task.verb in (codes.FORWARD, codes.LEFT) else -permille
        straight = self._task.verb in (codes.FORWARD, codes.BACKWARD)
        self._out = (signed, 0) if straight else (0, signed)

    def _check(self) -> None:
        steps = round(self._now_s / STEP_S)
        if self._walker is not None and not self._judged and steps % 10 == 0:
            self._judge_walker()
        speed = fastest(self._chair)
        self._farther_m -= STEP_S * (speed + (_WALKER_M_S if self._walker is not None else 0.0))
        if steps % _CHECK_STEPS or self._farther_m > NEAR_M:
            return
        if speed == 0.0 and self._walker is None:
            return
        gap_m = self._room.clearance_m(self._chair.x_m, self._chair.y_m, self._chair.heading_deg)
        self._farther_m = gap_m
        if speed > MOVING_M_S:
            self.outcome.least_m = min(self.outcome.least_m, gap_m)
        if gap_m <= 0.0:
            self.outcome.touched = True
            self.outcome.collided = speed > MOVING_M_S

    def _judge_walker(self) -> None:
        # At the end of a scan: is the walker in the sweep of the bare chair, straight ahead?
        assert self._walker is not None
        c = math.cos(math.radians(self._chair.heading_deg))
        s = math.sin(math.radians(self._chair.heading_deg))
        dx, dy = self._walker.x_m - self._chair.x_m, self._walker.y_m - self._chair.y_m
        ahead, aside = c * dx + s * dy, abs(c * dy - s * dx)
        inside = ahead > twin.FRONT_M and aside < twin.HALF_WIDTH_M + WALKER_RADIUS_M
        if inside and fastest(self._chair) > 0.0:
            self._judged = self.outcome.met = True
            self.outcome.stoppable = self._would_stop()

    def _would_stop(self) -> bool:
        """Whether a braking that starts now ends before contact."""
        assert self._task.walker is not None
        chair = copy.deepcopy(self._chair)
        room = Room("braking", self._room.walls, self._room.furniture)
        person = Person((self._task.walker.at(self._now_s),), radius_m=WALKER_RADIUS_M)
        room.people = (person,)
        now_s = self._now_s
        while fastest(chair) > MOVING_M_S:
            now_s += STEP_S
            chair.step(STEP_S, (0.0, 0.0))
            person.x_m, person.y_m = self._task.walker.at(now_s)
            if room.collides(chair.x_m, chair.y_m, chair.heading_deg):
                return fastest(chair) <= MOVING_M_S
        return True

    def _way(self, start: tuple[float, float, float]) -> float:
        if self._task.verb in (codes.FORWARD, codes.BACKWARD):
            return math.hypot(self._chair.x_m - start[0], self._chair.y_m - start[1])
        return abs(self._chair.heading_deg - start[2])

    def _stands(self) -> bool:
        return fastest(self._chair) == 0.0


def fastest(chair: Chair) -> float:
    """Speed of the fastest part of the chair, m/s."""
    return abs(chair.speed_m_s) + abs(math.radians(chair.yaw_rate_deg_s)) * _CORNER_M


def deliver(inputs: Inputs, clearance: Clearance, now_s: float) -> None:
    """Set the inputs as the board's link does for a CLEARANCE frame that arrives at `now_s`."""
    i = inputs
    (
        i.clearance_blocked,
        i.clearance_unseen,
        i.clearance_source,
        i.clearance_forward_mm,
        i.clearance_backward_mm,
        i.clearance_left_q4,
        i.clearance_right_q4,
        i.clearance_age_ms,
        i.clearance_arc_views,
        i.clearance_arcs,
    ) = clearance.fields(now_s)
    i.clearance_count = (i.clearance_count + 1) & 0xFFFF
