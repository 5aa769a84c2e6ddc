"""Smoothing: fewer and better vertices of a route, by a cost in seconds, as the board permits.

The board creeps where something is within the side margin, stops before what is ahead, and in turns
keeps its margins all round; places where it refused to go on cost more.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.going.bends import Bend, Point, bend_at, widest
from gazechair.going.costmap import Costmap
from gazechair.going.lattice import NO_TURN_M

Pose = tuple[float, float, float]
"""x, y in metres, heading in radians, of the drive axle in the map's frame."""

_EASY_M = 0.15
TURN_M, TURN_EASY_M = 0.075, 0.11
"""Least clearance of a turn, and the clearance from which it costs nothing extra."""
ALONG_M = 0.05
"""Distance between the poses of a leg that are checked."""
_NO_TURN_S = 30.0
_TURN_INTO_WALL_S_PER_M = 1500.0
_ROUND_RAD = math.radians(3.0)
_BEYOND_RAD = math.radians(16.0)  # room that the board requires to stop a turn
_SPEED_M_S = 0.25
_TURN_S, _TURN_RAD_S = 3.0, math.radians(20.0)
_SAME_RAD = math.radians(1.5)  # a smaller turn is none, even where the chair cannot steer
_STRAIGHT_RAD = math.radians(4.0)  # a smaller turn is steered while driving
_ONWARD_M = np.arange(0.05, 0.76, 0.05)
_BESIDE_M = 0.035
_JAMS_M, _JAMS_S_PER_M = 0.06, 40.0  # clearance at which an error of the pose may stop the chair
PASSES_M, _NOT_PASSED_S = 0.025, 40.0  # the board's side margin ahead of the chair
_LEAVES = 8  # first poses of a leg, which may be nearer: the chair moves away from that
_STOP_M = 0.35
_CREEPS_S_PER_M, _NO_STOP_S_PER_M = 20.0, 200.0
_REFUSED_M, _REFUSED_RAD = 0.3, math.radians(20.0)
_BEND_ROLLS_M, _BEND_ENDS_M = 0.1, 0.3  # straight before the first, after the last bend
_NO_BEND_M = 1.0  # no bends this near to where the board refused something
_MOVES_M = (0.04, 0.015)
_INTO_WALL = 60.0  # seconds per metre at zero clearance, down to none at 2 cm


@dataclass(frozen=True)
class Refused:
    """A pose at which the board refused to turn, or to go on, whatever the map says."""

    x_m: float
    y_m: float
    heading_rad: float
    turns: bool
    price_s: float
    """Cost of trying it again."""
    person: bool = False
    """It stands before what may be a person: from farther back, it meets them again."""

    @property
    def pose(self) -> Pose:
        """x, y and heading."""
        return self.x_m, self.y_m, self.heading_rad


class Smoother:
    """Removes and moves vertices of a route to lower its cost in seconds."""

    def __init__(
        self,
        costmap: Costmap,
        start_rad: float,
        goal_rad: float | None,
        backward: bool,
        refused: Sequence[Refused],
        go_on: Callable[[], None] = lambda: None,
    ) -> None:
        """`go_on` is called again and again; what it raises ends the smoothing."""
        self._costmap = costmap
        self._refused, self._go_on = refused, go_on
        self._start_rad, self._goal_rad, self._backward = start_rad, goal_rad, backward
        self._legs: dict[tuple[Point, Point], tuple[float, float, float]] = {}
        self._turns: dict[tuple[Point, float, float], float] = {}
        self._bends: dict[tuple[Point, Point, Point, float], Bend | None] = {}

    def __call__(
        self, points: list[FloatArray], fixed: int, fixed_end: int, moves: bool = True
    ) -> tuple[FloatArray, float, float]:
        """Vertices (N, 2), least clearance, seconds; `fixed`, `fixed_end` vertices stay.

        Without `moves` vertices are only removed: a fifth of the time, for a path that costs more.
        """
        found = [_point(one) for one in points]
        cost = self._cost(found)
        while True:
            kept = found
            for k in range(fixed, len(kept) - fixed_end):
                self._go_on()
                option = kept[:k] + kept[k + 1 :]
                price = self._cost(option, cost)
                if price < cost:
                    cost, found = price, option
            if found is kept:
                break
        for move_m in _MOVES_M if moves else ():
            for _ in range(4):
                before = cost
                for k in range(fixed, len(found) - fixed_end):
                    self._go_on()
                    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1)):
                        x, y = found[k]
                        moved = list(found)
                        moved[k] = x + dx * move_m, y + dy * move_m
                        price = self._cost(moved, cost - 1e-6)
                        if price < cost - 1e-6:
                            cost, found = price, moved
                if cost > before - 0.05:
                    break
        legs = [self._leg(a, b)[1] for a, b in itertools.pairwise(found)]
        return np.array(found), min(legs, default=0.0), cost

    def bends(self, points: FloatArray) -> tuple[Bend | None, ...]:
        """The bend at each vertex that `__call__` returned; None: a turn on the spot."""
        every = [_point(one) for one in points]
        return tuple(self._bend(every, k) for k in range(len(every)))

    def first_leg_s(self, a: FloatArray, b: FloatArray) -> float:
        """Seconds of the path's first leg, including those for what is ahead of its end."""
        leg_s, _, end_s = self._leg(_point(a), _point(b))
        return leg_s + end_s

    def _cost(self, points: list[Point], below_s: float = math.inf) -> float:
        """Seconds of the path; inf as soon as they cannot be less than `below_s`.

        First the least that each part can take; where that is little enough, the costmap is asked.
        """
        legs = list(itertools.pairwise(points))
        headings = _headings(legs, self._backward)
        rads = list(zip([self._start_rad, *headings], [*headings, self._goal_rad], strict=True))
        least_s = [math.dist(a, b) / _SPEED_M_S for a, b in legs]
        corners_s = [self._least_s(points, k, *rads[k]) for k in range(len(points))]
        total = sum(least_s) + sum(corners_s)
        if self._refused:
            total += sum(
                refused_s(self._refused, a, heading, math.dist(a, b))
                for k, ((a, b), heading) in enumerate(zip(legs, headings, strict=True))
                if k or not self._backward
            )
        for (a, b), least in zip(legs, least_s, strict=True):
            if total >= below_s:
                return math.inf
            total += self._leg(a, b)[0] - least
        for k, least in enumerate(corners_s):
            if total >= below_s:
                return math.inf
            total += self._corner_s(points, k, *rads[k]) - least
        return total

    def _least_s(self, points: list[Point], k: int, before: float, after: float | None) -> float:
        """The least that `_corner_s` can be."""
        if after is None:
            return 0.0
        bend = self._widest(points, k)
        turn_s = _least_turn_s(abs(math.remainder(after - before, 2.0 * math.pi)))
        return turn_s if bend is None else min(turn_s, bend.seconds)

    def _corner_s(self, points: list[Point], k: int, before: float, after: float | None) -> float:
        """Seconds of the bend at vertex `k`, or of the turn on the spot and the stop before it."""
        bend = self._bend(points, k)
        if bend is not None:
            return bend.seconds
        ends_s = self._leg(points[k - 1], points[k])[2] if k else 0.0
        return ends_s + (0.0 if after is None else self.turn_s(points[k], before, after))

    def _most_m(self, points: list[Point], k: int) -> float:
        """The longest tangent at vertex `k`, 0 for none; bends share the leg between them."""
        if not 0 < k < len(points) - 1 or (self._backward and k == 1):
            return 0.0
        a, b, c = points[k - 1 : k + 2]
        before, after = math.dist(a, b), math.dist(b, c)
        return min(
            before - _BEND_ROLLS_M if k == 1 else 0.5 * before,
            after - _BEND_ENDS_M if k == len(points) - 2 else 0.5 * after,
        )

    def _widest(self, points: list[Point], k: int) -> Bend | None:
        most_m = self._most_m(points, k)
        if most_m <= 0.0:
            return None
        a, b, c = points[k - 1 : k + 2]
        return widest(a, b, c, most_m)

    def _bend(self, points: list[Point], k: int) -> Bend | None:
        """The bend at vertex `k`, or None."""
        most_m = self._most_m(points, k)
        if most_m <= 0.0:
            return None
        a, b, c = points[k - 1 : k + 2]
        key = a, b, c, most_m
        if key not in self._bends:
            shut = any(math.dist((one.x_m, one.y_m), b) < _NO_BEND_M for one in self._refused)
            self._bends[key] = None if shut else bend_at(self._costmap, a, b, c, most_m)
        return self._bends[key]

    def _leg(self, begin: Point, end: Point) -> tuple[float, float, float]:
        """Seconds, least clearance in metres, and seconds for what is ahead of its end."""
        found = self._legs.get((begin, end))
        if found is None:
            a, b = np.array(begin), np.array(end)
            length = math.dist(begin, end)
            count = max(2, int(length / ALONG_M) + 1)
            at = a + (b - a) * np.linspace(0.0, 1.0, count)[:, None]
            heading = math.atan2(end[1] - begin[1], end[0] - begin[0])
            backward = self._backward and self._is_first(begin)
            if backward:
                heading += math.pi
            onward = b + (b - a) / max(length, 1e-6) * _ONWARD_M[:, None]
            poses = np.concatenate((at, onward))
            clear = self._costmap.clearance_m(
                poses[:, 0], poses[:, 1], np.full(len(poses), heading)
            )
            clear, beyond = clear[:count], clear[count:]
            free = np.append(_ONWARD_M[beyond < _BESIDE_M], _ONWARD_M[-1])[0]
            narrow = np.clip((_EASY_M - clear) / _EASY_M, 0.0, 1.0) ** 2
            seconds = length / _SPEED_M_S * (1.0 + 3.0 * float(narrow.mean()))
            seconds += _CREEPS_S_PER_M * length * float((clear < _BESIDE_M).mean())
            seconds += _JAMS_S_PER_M * length * float((clear < _JAMS_M).mean())
            ends_s = _CREEPS_S_PER_M * float(_ONWARD_M[-1] - free)
            ends_s += _NO_STOP_S_PER_M * max(0.0, _STOP_M - float(free))
            seconds += _INTO_WALL * length * float(np.maximum(0.02 - clear, 0.0).mean()) * 50.0
            standing_m = self._costmap.standing_m
            seconds += self._costmap.ahead.leg_s(standing_m, a, b, backward)
            if float(clear[_LEAVES:].min(initial=1.0)) < PASSES_M:
                seconds += _NOT_PASSED_S
            found = self._legs[begin, end] = (seconds, float(clear.min()), ends_s)
        return found

    def _is_first(self, a: Point) -> bool:
        if not hasattr(self, "_first"):
            self._first = a
        return a is self._first

    def turn_s(self, at: Point, before: float, after: float) -> float:
        """Seconds of a turn on the spot."""
        angle = math.remainder(after - before, 2.0 * math.pi)
        no_turn = turn_refused(self._refused, at) and abs(angle) > _SAME_RAD
        if abs(angle) < _STRAIGHT_RAD and not no_turn:
            return _least_turn_s(abs(angle))
        key = (at, before, after)
        found = self._turns.get(key)
        if found is None:
            clear = self._costmap.clearance_m(*turn_poses((*at, before), after))
            found = _TURN_S + abs(angle) / _TURN_RAD_S
            least = float(clear.min())
            found += 200.0 * max(0.0, TURN_EASY_M - least)
            found += _NO_TURN_S * (1.0 - least) if least < TURN_M else 0.0
            found += _TURN_INTO_WALL_S_PER_M * max(0.0, -least)
            if no_turn:
                found += _NO_TURN_S
            self._turns[key] = found
        return found


def turn_poses(
    pose: Pose, to_rad: float, beyond_rad: float = _BEYOND_RAD
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """x, y, heading of a turn on the spot, including the room beyond it that the board requires."""
    angle = math.remainder(to_rad - pose[2], 2.0 * math.pi)
    end = angle + math.copysign(beyond_rad, angle)
    steps = np.arange(0.0, abs(end), _ROUND_RAD)
    here = np.ones(len(steps))
    return pose[0] * here, pose[1] * here, pose[2] + np.copysign(steps, end)


def turn_refused(refused: Sequence[Refused], at: FloatArray | Point) -> bool:
    """Whether the board did not let the chair turn near there."""
    return any(
        one.turns and math.hypot(one.x_m - at[0], one.y_m - at[1]) < NO_TURN_M for one in refused
    )


def refused_s(
    refused: Sequence[Refused], at: FloatArray | Point, heading_rad: float, length_m: float = 0.0
) -> float:
    """Seconds that going on near a refused pose costs; 0: none is near. `length_m`: how far."""
    ux, uy = math.cos(heading_rad), math.sin(heading_rad)

    def near(one: Refused) -> bool:
        x, y = one.x_m - at[0], one.y_m - at[1]
        along = min(max(ux * x + uy * y, 0.0), length_m if one.person else 0.0)
        return math.hypot(x - along * ux, y - along * uy) < _REFUSED_M

    return max(
        (
            one.price_s
            for one in refused
            if not one.turns
            and near(one)
            and abs(math.remainder(heading_rad - one.heading_rad, 2.0 * math.pi)) < _REFUSED_RAD
        ),
        default=0.0,
    )


def _point(at: FloatArray) -> Point:
    return float(at[0]), float(at[1])


def _least_turn_s(angle_rad: float) -> float:
    """Seconds of a turn on the spot, or of one steered while driving, where all is free."""
    small = angle_rad < _STRAIGHT_RAD
    return 2.0 * angle_rad if small else _TURN_S + angle_rad / _TURN_RAD_S


def _headings(legs: list[tuple[Point, Point]], backward: bool) -> list[float]:
    found = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in legs]
    if backward:
        found[0] += math.pi
    return found
