"""One walk through a generated home: a leader whom the chair follows, and people who get between.

The leader goes from room to room, and either waits for the chair or walks on; after a loss the
leader comes back. Others cross between the two, come towards them, walk beside them, or wait beyond
a door and come out as the leader goes in.
"""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, field

import numpy as np

from gazechair.base.arrays import FloatArray
from gazesim.gaits import FOREIGN, PLAIN, Actor
from gazesim.home_routes import Pose, Router
from gazesim.homes import Home

STEP_S = 0.05
_BODIES_M = 0.45  # no two people are nearer to each other
_CHAIR_M = 0.35  # nobody walks nearer to the chair's rectangle
_WALL_M = 0.2
_FRONT_M = 0.65
_STANDS_M = 1.2  # in front of the chair, to be chosen
_WAITS_M = 2.3
_COMES_M = 2.8
_STUCK_S, _GIVES_WAY_S = 1.5, 2.5
_LEAVES_M = 1.3  # a person whose path ends farther from the leader leaves the home
_AWAY = (1e3, 1e3)
KINDS = ("cross", "towards", "beside", "door")


@dataclass
class Path:
    """A polyline, by the distance along it."""

    points: FloatArray
    along: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        steps = np.hypot(*np.diff(self.points, axis=0).T)
        self.along = np.concatenate(((0.0,), np.cumsum(steps)))

    @property
    def length_m(self) -> float:
        return float(self.along[-1])

    def at(self, s_m: float, left_m: float = 0.0) -> tuple[float, float]:
        """The point at `s_m`, or `left_m` to the left of it."""
        x = float(np.interp(s_m, self.along, self.points[:, 0]))
        y = float(np.interp(s_m, self.along, self.points[:, 1]))
        if left_m:
            a, b = self.at(s_m - 0.1), self.at(s_m + 0.1)
            size = max(math.dist(a, b), 1e-9)
            x, y = x - left_m * (b[1] - a[1]) / size, y + left_m * (b[0] - a[0]) / size
        return x, y


@dataclass
class Other:
    """Another person: their path, and when they start."""

    actor: Actor
    path: Path
    speed_m_s: float
    waits_for_m: float
    """They start when the leader has walked this far."""
    s_m: float = 0.0
    stuck_s: float = 0.0
    way: int = 1
    turns: int = 0
    gone: bool = False

    def leave(self) -> None:
        """Leave the home."""
        self.gone = True
        self.actor.go(*_AWAY)


class Walk:
    """The people of one walk, moved in steps of 50 ms. `kinds`: what the others do."""

    def __init__(self, home: Home, router: Router, seed: int, foreign: bool) -> None:
        chance = random.Random(f"walk {home.name} {seed} {foreign}")
        self._chance = chance
        self._segments = home.body_segments()
        self.path = _way(home, router, chance)
        self.doors_m = _doors(home, self.path)
        gait = chance.choice(FOREIGN) if foreign else PLAIN
        self.s_m = self._apart(0.0, 1)
        self.leader = Actor(*self.path.at(self.s_m), gait, chance)
        self.start = Pose(*self.path.at(0.0), 0.0)
        self.speed_m_s = chance.uniform(0.3, 0.8)
        if gait == "rollator":
            self.speed_m_s = chance.uniform(0.25, 0.45)
        self._patient = chance.random() < 0.7  # the leader waits for the chair
        self._pause_s = self._held_s = 0.0
        self.others: list[Other] = []
        gaits = [chance.choice(FOREIGN) if foreign else PLAIN for _ in range(4)]
        for kind, one in zip(chance.sample(KINDS, 3), gaits, strict=False):
            self._add(kind, one)
        home.people = (self.leader, *(one.actor for one in self.others))

    def _add(self, kind: str, gait: str) -> None:
        chance, path = self._chance, self.path
        last = max(3.5, path.length_m - 1.0)
        at = chance.choice(self.doors_m or [chance.uniform(3.5, last)])
        aside = chance.choice((-1.0, 1.0)) * chance.uniform(0.5, 0.75)
        speed = chance.uniform(0.4, 1.1)
        if kind == "cross":
            at = chance.uniform(2.5, last)
            x, y = path.at(at)
            a, b = self._clear(x, y, path.at(at, 2.2)), self._clear(x, y, path.at(at, -2.2))
            if chance.random() < 0.5:
                a, b = b, a
            # Crosses where the leader has just been, between chair and leader.
            points, waits = [a, (x, y), b], at + chance.uniform(0.45, 1.2)
        elif kind == "beside":
            begin = min(at + chance.uniform(-1.0, 1.0), last)
            points = [self._free(path, s, aside) for s in np.arange(begin, begin + 3.5, 0.2)]
            speed, waits = self.speed_m_s, begin - 0.2
        elif kind == "towards":
            begin = min(at + 2.0, path.length_m)
            points = [self._free(path, s, aside) for s in np.arange(begin, 1.0, -0.2)]
            waits = begin - chance.uniform(1.5, 3.5)
        else:  # beyond the door, until the leader has just passed
            begin = min(at + chance.uniform(0.7, 1.4), path.length_m)
            points = [self._free(path, begin, aside)]
            points += [self._free(path, s, 0.0) for s in np.arange(begin - 0.6, 1.0, -0.2)]
            waits = begin + chance.uniform(-0.1, 0.7)
        actor = Actor(*points[0], gait, chance)
        self.others.append(Other(actor, Path(np.array(points)), speed, waits))

    def step(self, chair: Pose, seen: bool, chosen: bool) -> None:
        """`seen`: the lidar sees the leader. `chosen`: if not, the leader comes to the chair."""
        before = [(one.x_m, one.y_m) for one in self._all()]
        self._lead(chair, seen, chosen)
        leader = self.leader.x_m, self.leader.y_m
        for one in self.others:
            if one.gone or (self.s_m < one.waits_for_m and one.s_m == 0.0):
                continue
            ended = one.s_m >= one.path.length_m or one.turns > 2
            if ended and math.dist((one.actor.x_m, one.actor.y_m), leader) > _LEAVES_M:
                one.leave()
                continue
            s_m = min(max(one.s_m + one.way * one.speed_m_s * STEP_S, 0.0), one.path.length_m)
            if self._goes(one.actor, one.path.at(s_m), chair):
                one.s_m, one.stuck_s = max(s_m, 1e-6), 0.0
            else:
                one.stuck_s += STEP_S
                if one.stuck_s > _STUCK_S:
                    one.way, one.stuck_s = -one.way, 0.0
                    one.turns += 1

        for actor, place in zip(self._all(), before, strict=True):
            if (actor.x_m, actor.y_m) == place:
                actor.stand()

    def _all(self) -> list[Actor]:
        return [self.leader, *(one.actor for one in self.others)]

    def _lead(self, chair: Pose, seen: bool, chosen: bool) -> None:
        far_m = math.dist((chair.x_m, chair.y_m), (self.leader.x_m, self.leader.y_m)) - _FRONT_M
        if not chosen:
            # Walk back along the path, and stand before the chair.
            if not seen:
                self._to(self.s_m - 0.5 * STEP_S, chair)
            elif abs(far_m - _STANDS_M) > 0.1:
                step = math.copysign(min(0.5 * STEP_S, abs(far_m - _STANDS_M)), _STANDS_M - far_m)
                self._to(self.s_m + step, chair)
            return
        self._pause_s -= STEP_S
        if self._chance.random() < 0.05 * STEP_S:
            self._pause_s = self._chance.uniform(0.5, 3.0)
        speed = self.speed_m_s
        if self._patient:  # slows down for the chair, and does not walk out of its sight
            speed *= min(max((_WAITS_M - far_m) / 0.6, 0.0), 1.0)
            if not seen and far_m > _STANDS_M + 0.15:
                speed = 0.0
        if self._pause_s <= 0.0:
            self._to(self.s_m + speed * STEP_S, chair)

    def _apart(self, s_m: float, way: int) -> float:
        """The next point of the path that is _COMES_M from there."""
        here, s = self.path.at(s_m), s_m
        while math.dist(self.path.at(s), here) < _COMES_M and 0.0 <= s <= self.path.length_m:
            s += way * 0.1
        return s

    def behind(self) -> Pose:
        """A pose well behind the leader on the path, facing the leader."""
        x, y = self.path.at(self._apart(self.s_m, -1))
        turned = math.atan2(self.leader.y_m - y, self.leader.x_m - x)
        return Pose(x, y, math.degrees(turned))

    def ahead(self, step_m: float) -> None:
        """Move the leader by `step_m` along the path."""
        self.s_m = min(self.s_m + step_m, self.path.length_m)
        self.leader.go(*self.path.at(self.s_m))

    def _to(self, s_m: float, chair: Pose) -> None:
        s_m = min(max(s_m, 0.0), self.path.length_m)
        if self._goes(self.leader, self.path.at(s_m), chair):
            self.s_m, self._held_s = s_m, 0.0
            return
        self._held_s += STEP_S
        if self._held_s > _GIVES_WAY_S:
            for one in self.others:
                if math.dist((one.actor.x_m, one.actor.y_m), self.path.at(s_m)) < 2 * _BODIES_M:
                    one.leave()

    @property
    def done(self) -> bool:
        """True if the leader has reached the end."""
        return self.s_m >= self.path.length_m - 0.05

    def _goes(self, actor: Actor, to: tuple[float, float], chair: Pose) -> bool:
        here = actor.x_m, actor.y_m
        for one in self._all():
            there = one.x_m, one.y_m
            if one is not actor and math.dist(to, there) < min(_BODIES_M, math.dist(here, there)):
                return False
        if _to_chair(to, chair) < min(_CHAIR_M, _to_chair(here, chair)):
            return False
        actor.go(*to)
        return True

    def _free(self, path: Path, s_m: float, left_m: float) -> tuple[float, float]:
        for share in (1.0, 0.8, 0.6, 0.4, 0.2):
            point = path.at(float(s_m), share * left_m)
            if self._room_m(point) > _WALL_M:
                return point
        return path.at(float(s_m))

    def _clear(self, x: float, y: float, end: tuple[float, float]) -> tuple[float, float]:
        """The farthest point towards `end` with enough room."""
        found = (x, y)
        for share in np.linspace(0.1, 1.0, 10):
            point = x + share * (end[0] - x), y + share * (end[1] - y)
            if self._room_m(point) < _WALL_M:
                break
            found = point
        return found

    def _room_m(self, point: tuple[float, float]) -> float:
        a, b = self._segments[:, :2], self._segments[:, 2:]
        along = b - a
        share = ((point - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-12)
        gap = a + np.clip(share, 0.0, 1.0)[:, None] * along - point
        return float(np.hypot(gap[:, 0], gap[:, 1]).min())


def _to_chair(point: tuple[float, float], chair: Pose) -> float:
    """Distance of a point from the chair's rectangle, m."""
    turned = math.radians(chair.heading_deg)
    dx, dy = point[0] - chair.x_m, point[1] - chair.y_m
    ahead = math.cos(turned) * dx + math.sin(turned) * dy
    left = math.cos(turned) * dy - math.sin(turned) * dx
    return math.hypot(max(ahead - 0.65, -0.45 - ahead, 0.0), max(abs(left) - 0.375, 0.0))


def _way(home: Home, router: Router, chance: random.Random) -> Path:
    """A smoothed path from one room to another, at least 6 m long."""
    names = sorted(home.places)
    for _ in range(20):
        begin, end = chance.sample(names, 2)
        place = router.place(*home.places[begin])
        if place is None:
            continue
        route = router.route(router.costs_to(*home.places[end]), Pose(*place, 0.0))
        points = np.array([(one.x_m, one.y_m) for one in route])
        if not len(points):
            continue
        points = points[np.concatenate(((True,), np.abs(np.diff(points, axis=0)).sum(axis=1) > 0))]
        if len(points) > 2 and Path(points).length_m >= 6.0:
            path = Path(points)
            even = np.arange(0.0, path.length_m, 0.1)
            return Path(np.array([path.at(s) for s in even]))
    raise ValueError(f"no way of 6 m in {home.name}")


def _doors(home: Home, path: Path) -> list[float]:
    """Where the path passes doors, m along it."""
    found = []
    for door in home.doors:
        x, y = 0.5 * (door.hinge[0] + door.jamb[0]), 0.5 * (door.hinge[1] + door.jamb[1])
        far = np.hypot(path.points[:, 0] - x, path.points[:, 1] - y)
        if far.min() < 0.35 and path.along[far.argmin()] > 3.0:
            found.append(float(path.along[far.argmin()]))
    return found
