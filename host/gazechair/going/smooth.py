"""Smoothing: fewer and better vertices of a route, by a cost in seconds, as the board permits.

The board creeps where something is within the side margin, stops before what is ahead, and in turns
keeps its margins all round; places where it refused to go on cost more.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.going.bends import Bend, bend_at
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
    ) -> None:
        self._costmap = costmap
        self._refused = refused
        self._start_rad, self._goal_rad, self._backward = start_rad, goal_rad, backward
        self._legs: dict[tuple[float, ...], tuple[float, float, float]] = {}
        self._turns: dict[tuple[float, ...], float] = {}
        self._bends: dict[tuple[float, ...], Bend | None] = {}

    def __call__(
        self, points: list[FloatArray], fixed: int, fixed_end: int
    ) -> tuple[FloatArray, float, float]:
        """Vertices (N, 2), least clearance, seconds; `fixed`, `fixed_end` vertices stay."""
        cost = self._cost(points)
        while True:
            options = [points[:k] + points[k + 1 :] for k in range(fixed, len(points) - fixed_end)]
            priced = [(self._cost(option), n) for n, option in enumerate(options)]
            best = min(priced, default=(math.inf, 0))
            if best[0] >= cost:
                break
            cost, points = best[0], options[best[1]]
        for move_m in _MOVES_M:
            for _ in range(4):
                before = cost
                for k in range(fixed, len(points) - fixed_end):
                    for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, -1)):
                        moved = list(points)
                        moved[k] = points[k] + (dx * move_m, dy * move_m)
                        price = self._cost(moved)
                        if price < cost - 1e-6:
                            cost, points = price, moved
                if cost > before - 0.05:
                    break
        legs = [self._leg(a, b)[1] for a, b in itertools.pairwise(points)]
        return np.array(points), min(legs, default=0.0), cost

    def bends(self, points: FloatArray) -> tuple[Bend | None, ...]:
        """The bend at each vertex that `__call__` returned; None: a turn on the spot."""
        every = list(points)
        inner = [self._bend(every, k) for k in range(1, len(every) - 1)]
        return (None, *inner, None)

    def first_leg_s(self, a: FloatArray, b: FloatArray) -> float:
        """Seconds of the path's first leg, including those for what is ahead of its end."""
        leg_s, _, end_s = self._leg(a, b)
        return leg_s + end_s

    def _cost(self, points: list[FloatArray]) -> float:
        backward = self._backward
        headings = _headings(points, backward)
        total, before = 0.0, self._start_rad
        ends_s = 0.0  # of the leg before: for what is ahead of its end, unless a bend leads away
        for k, heading in enumerate(headings):
            bend = self._bend(points, k) if k else None
            total += (
                ends_s + self.turn_s(points[k], before, heading) if bend is None else bend.seconds
            )
            leg_s, _, ends_s = self._leg(points[k], points[k + 1])
            total += leg_s
            if not (backward and not k):
                total += refused_s(self._refused, points[k], heading)
            before = heading
        total += ends_s
        if self._goal_rad is not None:
            total += self.turn_s(points[-1], before, self._goal_rad)
        return total

    def _bend(self, points: list[FloatArray], k: int) -> Bend | None:
        """The bend at vertex `k`, or None; neighbouring bends share the leg between them."""
        a, b, c = points[k - 1 : k + 2]
        if self._backward and k == 1:
            return None
        before, after = float(np.hypot(*(b - a))), float(np.hypot(*(c - b)))
        most_m = min(
            before - _BEND_ROLLS_M if k == 1 else 0.5 * before,
            after - _BEND_ENDS_M if k == len(points) - 2 else 0.5 * after,
        )
        key = (*a.tolist(), *b.tolist(), *c.tolist(), most_m)
        if key not in self._bends:
            shut = any(math.dist((one.x_m, one.y_m), b) < _NO_BEND_M for one in self._refused)
            self._bends[key] = None if shut else bend_at(self._costmap, a, b, c, most_m)
        return self._bends[key]

    def _leg(self, a: FloatArray, b: FloatArray) -> tuple[float, float, float]:
        """Seconds, least clearance in metres, and seconds for what is ahead of its end."""
        key = (*a.tolist(), *b.tolist())
        found = self._legs.get(key)
        if found is None:
            length = float(np.hypot(*(b - a)))
            count = max(2, int(length / ALONG_M) + 1)
            at = a + (b - a) * np.linspace(0.0, 1.0, count)[:, None]
            heading = math.atan2(b[1] - a[1], b[0] - a[0])
            backward = self._backward and a is not b and self._is_first(a)
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
            found = self._legs[key] = (seconds, float(clear.min()), ends_s)
        return found

    def _is_first(self, a: FloatArray) -> bool:
        if not hasattr(self, "_first"):
            self._first = a
        return a is self._first

    def turn_s(self, at: FloatArray, before: float, after: float) -> float:
        """Seconds of a turn on the spot."""
        angle = math.remainder(after - before, 2.0 * math.pi)
        no_turn = turn_refused(self._refused, at) and abs(angle) > _SAME_RAD
        if abs(angle) < _STRAIGHT_RAD and not no_turn:
            return 2.0 * abs(angle)
        key = (*at.tolist(), before, after)
        found = self._turns.get(key)
        if found is None:
            pose = float(at[0]), float(at[1]), before
            clear = self._costmap.clearance_m(*turn_poses(pose, after))
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


def turn_refused(refused: Sequence[Refused], at: FloatArray) -> bool:
    """Whether the board did not let the chair turn near there."""
    return any(
        one.turns and math.hypot(one.x_m - at[0], one.y_m - at[1]) < NO_TURN_M for one in refused
    )


def refused_s(refused: Sequence[Refused], at: FloatArray, heading_rad: float) -> float:
    """Seconds that going on near a refused pose costs; 0: none is near."""
    return max(
        (
            one.price_s
            for one in refused
            if not one.turns
            and math.hypot(one.x_m - at[0], one.y_m - at[1]) < _REFUSED_M
            and abs(math.remainder(heading_rad - one.heading_rad, 2.0 * math.pi)) < _REFUSED_RAD
        ),
        default=0.0,
    )


def _headings(points: list[FloatArray], backward: bool) -> list[float]:
    found = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in itertools.pairwise(points)]
    if backward:
        found[0] += math.pi
    return found
