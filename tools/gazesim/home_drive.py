"""A drive through a home in virtual time: the sensors' data, and the truth.

A kinematic chair (dead time, lag, ramps, wavering speeds) and a driver who turns on the spot and
drives straight, along routes through the doors, as with the driver's page. Lidars measure while
the chair moves; the heading has the errors of the board's sensor.
"""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import FloatArray
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazesim.home_routes import HEADINGS_DEG, Costs, Pose, Router
from gazesim.homes import FARTHEST_M, Home
from gazesim.lidar_noise import MISSING, NOISE_M

STEP_S = 0.01
_HEAR_S = 0.02  # between two states of the board
_PEOPLE_S = 0.05
_TURN_S = 0.1  # one turn of the mirror
LIDAR_HEIGHT_M = 0.25
_NEAREST_M = 0.05

_DEAD_S = 0.15
_LAG_S = 0.25
_TURNING_DEG_S = 40.0
_RAMP_M_S2, _RAMP_DEG_S2 = 0.6, 80.0
_FORGET_S = 1.0


@dataclass(frozen=True)
class Mounted:
    """A lidar on the chair: place, direction of its front, and view to each side of that."""

    x_m: float
    y_m: float
    heading_deg: float
    half_deg: float


FRONT = Mounted(0.50, 0.0, 0.0, 122.0)
REAR = Mounted(-0.42, 0.0, 180.0, 94.0)


@dataclass(frozen=True)
class Truth:
    """The chair at one time: the drive axle's pose, and its speeds."""

    time_s: float
    x_m: float
    y_m: float
    heading_deg: float
    speed_m_s: float
    yaw_rate_deg_s: float


class Axis:
    """A speed that follows the wanted one with delay, ramps and errors."""

    def __init__(self, ramp: float, chance: random.Random) -> None:
        self.speed = 0.0
        self._ramp = ramp * STEP_S
        self._gain = chance.uniform(0.9, 1.1)
        self._veer = 0.0
        self._ramped = 0.0
        self._pending: deque[float] = deque([0.0] * round(_DEAD_S / STEP_S))
        self._chance = chance

    def step(self, wanted: float) -> float:
        """10 ms with this wanted speed; returns the distance travelled."""
        self._pending.append(wanted * self._gain)
        wanted = self._pending.popleft()
        self._ramped += max(-self._ramp, min(wanted - self._ramped, self._ramp))
        self._veer += (self._chance.gauss(0.0, 0.2) - self._veer) * STEP_S / 0.5
        before = self.speed
        self.speed += (self._ramped * (1.0 + self._veer) - before) * STEP_S / _LAG_S
        return 0.5 * (before + self.speed) * STEP_S

    def halt(self) -> None:
        """Stop at once."""
        self.speed = self._ramped = 0.0
        self._pending = deque([0.0] * len(self._pending))


class Driver:
    """Drives from place to place: turns on the spot, then straight on. Waits for people.

    The chair keeps exactly to its route, so that it hits nothing; its speed is not exact at all.
    """

    def __init__(self, home: Home, chance: random.Random) -> None:
        self._home = home
        self._chance = chance
        self._router = Router(home)
        self._furniture = home.furniture
        self._costs: dict[str, Costs] = {}
        self.full_m_s = chance.uniform(0.35, 0.7)
        self._linear = Axis(_RAMP_M_S2, chance)
        self._turn = Axis(_RAMP_DEG_S2, chance)
        self.permille = (0, 0)
        """Forward and turn, as the board would put out."""
        self.pose = self._begin()
        self.route: deque[Pose] = deque()
        self._held = False

    @property
    def speeds(self) -> tuple[float, float]:
        """The chair's speeds, m/s and deg/s."""
        return self._linear.speed, self._turn.speed

    def _begin(self) -> Pose:
        places = [self._home.places[name] for name in sorted(self._home.places)]
        self._chance.shuffle(places)
        for place in places:
            found = self._router.place(*place)
            if found is not None and all(
                math.dist(found, (person.x_m, person.y_m)) > 1.5 for person in self._home.people
            ):
                return Pose(*found, self._chance.choice(HEADINGS_DEG))
        raise ValueError(f"no place to begin at in {self._home.name}")

    def look(self) -> None:
        """Call every 50 ms: waits for people in the way; opens closed doors."""
        if not self.route:
            self._plan()
        self._held = self._in_the_way()
        ahead = list(self.route)[:25]
        for door in self._home.doors:
            x, y = 0.5 * (door.hinge[0] + door.jamb[0]), 0.5 * (door.hinge[1] + door.jamb[1])
            if not door.open and any(math.dist((p.x_m, p.y_m), (x, y)) < 1.0 for p in ahead):
                self._held = True
                near = math.dist((self.pose.x_m, self.pose.y_m), (x, y))
                if near > 1.3 or not self._home.people:
                    self._home.set_door(door.name, True)

    def step(self) -> None:
        """Drive for 10 ms."""
        linear = turn = 0.0
        if self.route and not self._held:
            aim, left_m = self._straight()
            error = half_turn_deg(aim.heading_deg - self.pose.heading_deg)
            if abs(error) > 1e-6:
                turn = math.copysign(min(_TURNING_DEG_S, 1.0 + 1.6 * abs(error)), error)
            else:
                linear = min(self.full_m_s, 0.02 + 0.6 * left_m)
        self.permille = (round(1000 * linear / self.full_m_s), round(1000 * turn / _TURNING_DEG_S))
        forward_m, turned_deg = self._linear.step(linear), self._turn.step(turn)
        while self.route and (forward_m > 0.0 or turned_deg):
            aim, _ = self._straight()
            error = half_turn_deg(aim.heading_deg - self.pose.heading_deg)
            if abs(error) > 1e-6:
                if turned_deg * error <= 0.0:
                    return
                step = math.copysign(min(abs(turned_deg), abs(error)), error)
                self.pose = replace(self.pose, heading_deg=self.pose.heading_deg + step)
                if abs(turned_deg) < abs(error):
                    return
                turned_deg = 0.0
                self._turn.halt()
                continue
            aim = self.route[0]
            left_m = math.dist((aim.x_m, aim.y_m), (self.pose.x_m, self.pose.y_m))
            if forward_m < left_m:
                share = forward_m / left_m
                self.pose = replace(
                    self.pose,
                    x_m=self.pose.x_m + share * (aim.x_m - self.pose.x_m),
                    y_m=self.pose.y_m + share * (aim.y_m - self.pose.y_m),
                )
                return
            forward_m -= left_m
            self.pose = replace(aim, heading_deg=self.pose.heading_deg)
            self.route.popleft()
            onward = self.route[0] if self.route else None
            if onward is None or abs(half_turn_deg(onward.heading_deg - aim.heading_deg)) > 1e-6:
                self._linear.halt()
                return

    def _straight(self) -> tuple[Pose, float]:
        """The next pose of the route, and the distance to where it next turns."""
        aim, last = self.route[0], self.route[0]
        for pose in self.route:
            if pose.heading_deg != aim.heading_deg:
                break
            last = pose
        return aim, math.dist((last.x_m, last.y_m), (self.pose.x_m, self.pose.y_m))

    def _plan(self) -> None:
        if self._home.furniture is not self._furniture:
            self._furniture = self._home.furniture
            self._router, self._costs = Router(self._home), {}
        here = self.pose.x_m, self.pose.y_m
        names = sorted(self._home.places)
        far = [name for name in names if math.dist(self._home.places[name], here) > 1.5]
        name = self._chance.choice(far or names)
        if name not in self._costs:
            self._costs[name] = self._router.costs_to(*self._home.places[name])
        self.route = deque(self._router.route(self._costs[name], self.pose)[1:])

    def _in_the_way(self) -> bool:
        turned = math.radians(self.pose.heading_deg)
        c, s = math.cos(turned), math.sin(turned)
        for person in self._home.people:
            dx, dy = person.x_m - self.pose.x_m, person.y_m - self.pose.y_m
            ahead, aside = c * dx + s * dy, c * dy - s * dx
            if math.hypot(dx, dy) < 1.0 or (0.0 < ahead < 1.6 and abs(aside) < 0.7):
                return True
        return False


class Drive:
    """One drive. Iterate over `events`; `truth` knows every time of the last second."""

    def __init__(
        self,
        home: Home,
        seed: int,
        lidars: tuple[Mounted, ...] = (FRONT, REAR),
        per_turn: int = 1600,
    ) -> None:
        chance = random.Random(f"drive {home.name} {seed}")
        self.home = home
        self.lidars = lidars
        self.way_m = 0.0
        self.time_s = 0.0
        self._per_turn = per_turn
        self._random = np.random.default_rng(chance.randrange(1 << 30))
        self.driver = Driver(home, chance)
        home.start = (self.driver.pose.x_m, self.driver.pose.y_m, self.driver.pose.heading_deg)
        self._scale = 1.0 + chance.choice((-0.005, 0.005))
        self._drift_deg_s = chance.choice((-0.3, 0.3)) / 60.0
        self._first_deg = chance.uniform(0.0, 360.0)
        self._began_deg = self.driver.pose.heading_deg
        self._past: deque[Truth] = deque()

    def events(self, seconds: float) -> Iterator[Motion | Piece]:
        """The sensors' data, in the order of arrival."""
        half = round(0.5 * _TURN_S / STEP_S)
        offsets = [round(k * half / len(self.lidars)) for k in range(len(self.lidars))]
        driver = self.driver
        self._note()
        for step in range(1, round(seconds / STEP_S) + 1):
            self.time_s = step * STEP_S
            before = driver.pose
            if step % round(_PEOPLE_S / STEP_S) == 0:
                pose = before.x_m, before.y_m, before.heading_deg
                ways = [(p.x_m, p.y_m, p.heading_deg) for p in driver.route]
                self.home.walk(_PEOPLE_S, *pose, ways)
                driver.look()
            driver.step()
            self.way_m += math.hypot(driver.pose.x_m - before.x_m, driver.pose.y_m - before.y_m)
            self._note()
            if step % round(_HEAR_S / STEP_S) == 0:
                yield self._motion()
            for number, offset in enumerate(offsets):
                if step > half and (step - offset) % half == 0:
                    piece = self._piece(self.lidars[number], (step - offset) // half % 2)
                    yield replace(piece, lidar=number)

    def truth(self, time_s: float) -> Truth:
        """The truth at a time of the last second, interpolated."""
        times = [one.time_s for one in self._past]
        at = min(max(int(np.searchsorted(times, time_s)), 1), len(times) - 1)
        a, b = self._past[at - 1], self._past[at]
        share = min(max((time_s - a.time_s) / (b.time_s - a.time_s), 0.0), 1.0)
        mixed = [
            x + share * (y - x)
            for x, y in (
                (a.x_m, b.x_m),
                (a.y_m, b.y_m),
                (a.heading_deg, b.heading_deg),
                (a.speed_m_s, b.speed_m_s),
                (a.yaw_rate_deg_s, b.yaw_rate_deg_s),
            )
        ]
        return Truth(time_s, *mixed)

    def _note(self) -> None:
        pose = self.driver.pose
        self._past.append(
            Truth(self.time_s, pose.x_m, pose.y_m, pose.heading_deg, *self.driver.speeds)
        )
        while self._past[0].time_s < self.time_s - _FORGET_S:
            self._past.popleft()

    def _motion(self) -> Motion:
        turned = (self.driver.pose.heading_deg - self._began_deg) * self._scale
        heading = self._first_deg + turned + self._drift_deg_s * self.time_s
        heading += self._random.normal(0.0, 0.1)
        heading = round(heading * 16.0) / 16.0 % 360.0
        return Motion(self.time_s, heading, *self.driver.permille)

    def _piece(self, lidar: Mounted, half: int) -> Piece:
        """The half turn that has just ended, as measured by the moving chair."""
        count = self._per_turn // 2
        share = (np.arange(count) + 0.5) / count
        times = self.time_s - 0.5 * _TURN_S * (1.0 - share)
        own = -(share + half) * 180.0  # the mirror turns clockwise
        seen = np.abs(half_turn_deg(own)) <= lidar.half_deg
        own, times = own[seen], times[seen]
        directions = half_turn_deg(own + lidar.heading_deg)
        past = [one for one in self._past if one.time_s >= self.time_s - _TURN_S]
        known = [one.time_s for one in past]
        x = np.interp(times, known, [one.x_m for one in past])
        y = np.interp(times, known, [one.y_m for one in past])
        heading = np.radians(np.interp(times, known, [one.heading_deg for one in past]))
        c, s = np.cos(heading), np.sin(heading)
        x, y = x + c * lidar.x_m - s * lidar.y_m, y + s * lidar.x_m + c * lidar.y_m
        metres = self._ranges(x, y, heading + np.radians(own + lidar.heading_deg))
        return Piece(directions, metres, times, (lidar.x_m, lidar.y_m), self._per_turn)

    def _ranges(self, x_m: FloatArray, y_m: FloatArray, angles_rad: FloatArray) -> FloatArray:
        turned = angles_rad % (2.0 * math.pi)
        order = np.argsort(turned, kind="stable")
        metres = np.empty(len(order))
        metres[order] = self.home.cast_moving(x_m[order], y_m[order], turned[order], LIDAR_HEIGHT_M)
        seen = (metres >= _NEAREST_M) & (metres <= FARTHEST_M)
        seen &= self._random.random(len(metres)) >= MISSING
        noisy = np.round((metres + self._random.normal(0.0, NOISE_M, len(metres))) * 1000.0)
        return np.where(seen, noisy / 1000.0, 0.0)
