"""Planner: from a pose to a place, as straight legs with bends or turns on the spot between them.

The lattice finds a route; smoothing takes vertices out and moves the others until legs are long
and clear on both sides. Where it is too narrow to turn, the path begins or ends with a straight
leg at the heading that the chair has, or must have, there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.going.costmap import Costmap
from gazechair.going.lattice import LOOSE_M, NO_TURN_M, STEP_M, STRICT_M, UNREACHED, Lattice
from gazechair.going.path import NO_LEG_M, Abandoned, NoPath, Path
from gazechair.going.smooth import (
    ALONG_M,
    TURN_EASY_M,
    TURN_M,
    Pose,
    Refused,
    Smoother,
    refused_s,
    turn_poses,
    turn_refused,
)

__all__ = [
    "GOAL_BLOCKED",
    "NO_WAY",
    "START_BLOCKED",
    "NoPath",
    "Path",
    "Planner",
    "Pose",
    "Refused",
]

GOAL_BLOCKED, START_BLOCKED, NO_WAY = "going_goal_blocked", "going_start_blocked", "going_no_way"

ARRIVED_M = 0.12
"""Nearer to the goal, the chair has arrived."""
_HERE_M, _HERE_RAD = 0.08, math.radians(5.0)  # nearer: no leg, and no turn that may be refused
LEAST_M = -0.01
"""Least clearance of a path, by the map, whose own error is as large; the board guards the rest."""
_TURNS_NEARER_M = 0.03  # than legs: where the board refuses a turn, another path is found
# Least clearance of poses and turns in the search, and whether a leg straight on comes first; tried
# in this order until a path is easy. In turns the board keeps 7 cm off; a loose search may give a
# route that smoothing cannot clear.
_TRIES = (
    (LOOSE_M, 0.085, False), (LOOSE_M, 0.085, True), (LOOSE_M, 0.04, False),
    (STRICT_M, 0.03, False), (LOOSE_M, 0.0, False),
)  # fmt: skip
_LEG_STEPS_M = (0.0, 0.3, 0.6, 0.9, 1.2, 1.6)
_GOAL_M = 0.9 * STEP_M
_SNAP_RAD, _ROUND_RAD = math.radians(12.0), math.radians(5.0)
_COST_PER_S = 15.0  # of the lattice
_SHORT_S_PER_M = 600.0  # of ending within _GOAL_M of the goal

Headings = tuple[float, float | None]
"""At the start, and at the goal (None: any), in radians."""


class Planner:
    """Plans on one costmap; the lattice's clearances are kept until the costmap changes."""

    def __init__(self, costmap: Costmap, may_reverse: bool = False) -> None:
        """`may_reverse`: lidars see behind the chair."""
        self._costmap = costmap
        self._lattice = Lattice(costmap)
        self._may_reverse = may_reverse
        self._refused: Sequence[Refused] = ()
        self._hurries = False
        self._over: Callable[[], bool] = lambda: False

    def plan(
        self,
        start: Pose,
        goal: Pose | tuple[float, float],
        refused: Sequence[Refused] = (),
        hurry: bool = False,
        over: Callable[[], bool] = lambda: False,
    ) -> Path | NoPath:
        """The path; takes 0.1 to 0.3 s, longer where it is narrow, unless in a `hurry`.

        A goal without a heading allows any. `hurry`: the first path found, though not the easiest
        and hardly smoothed. `over`: nobody waits for it any more; it soon raises Abandoned.
        """
        self._refused, self._hurries, self._over = refused, hurry, over
        here = self._here(start, goal)
        if here is not None and math.dist(start[:2], goal[:2]) <= _HERE_M:
            return here
        self._lattice.refresh()
        turns = [(one.x_m, one.y_m) for one in refused if one.turns]
        best: Path | NoPath = NoPath(NO_WAY)
        for least_m, turn_m, leg in _TRIES:
            self._go_on()
            self._lattice.use(least_m, turn_m, turns)
            found = self._plan(start, goal, leg)
            if isinstance(found, NoPath):
                if found.reason != NO_WAY:
                    return found
            elif isinstance(best, NoPath) or found.cost_s < best.cost_s:
                best = found
            if isinstance(best, Path) and (hurry or best.is_easy):
                break
        easy = isinstance(best, Path) and best.is_easy
        return best if here is None or easy else here

    def _go_on(self) -> None:
        if self._over():
            raise Abandoned

    def _smoother(self, rads: Headings, backward: bool) -> Smoother:
        return Smoother(self._costmap, *rads, backward, self._refused, self._go_on)

    def _here(self, start: Pose, goal: Pose | tuple[float, float]) -> Path | None:
        """The last turn alone, for a chair that stands at its goal; None: that is not enough."""
        if math.dist(start[:2], goal[:2]) > ARRIVED_M:
            return None
        heading = goal[2] if len(goal) == 3 else None
        place = np.array(start[:2])
        if heading is not None and not (
            self.turns_freely(start, heading) and not turn_refused(self._refused, place)
        ):
            if abs(math.remainder(heading - start[2], 2.0 * math.pi)) > _HERE_RAD:
                return None
            heading = None
        return Path(np.array((place, place)), heading, clearance_m=math.inf)

    def turns_freely(self, pose: Pose, to_rad: float) -> bool:
        """Whether the board will allow a turn on the spot from `pose` to `to_rad`."""
        clear = self._costmap.clearance_m(*turn_poses(pose, to_rad))
        return bool(clear.min() >= TURN_M)

    def _plan(self, start: Pose, goal: Pose | tuple[float, float], leg: bool) -> Path | NoPath:
        """`leg`: begin straight on where possible, not with a turn, however small.

        So does a path from where the board refused a turn, or straight back.
        """
        heading = goal[2] if len(goal) == 3 else None
        goals = self._ends(goal[0], goal[1], heading)
        if not len(goals[0]):
            return NoPath(GOAL_BLOCKED)
        starts = self._starts(start)
        if not starts:
            return NoPath(START_BLOCKED)
        no_turn = turn_refused(self._refused, np.array(start[:2]))
        if leg or no_turn:
            starts = [one for one in starts if one[1] > 0.0 or (no_turn and one[1])] or starts
        every = np.concatenate([one[0] for one in starts])
        costs = self._lattice.costs_to(goals[0], goals[1], every, self._go_on)
        best = None
        first = self._smoother((start[2], heading), False)
        for poses, leg_m, leg_s in starts:
            for pose in poses[costs[poses] < UNREACHED]:
                off = math.remainder(self._lattice.heading_rad(pose) - start[2], 2.0 * math.pi)
                gap = self._lattice.metres(np.array([pose]))[0] - _ahead(start, leg_m)
                price = costs[pose] + 20.0 * abs(off) + 200.0 * float(np.hypot(*gap))
                price += _COST_PER_S * leg_s
                if no_turn:
                    x, y = _ahead(start, leg_m)
                    price += _COST_PER_S * first.turn_s(
                        (float(x), float(y)), start[2], start[2] + off
                    )
                if best is None or price < best[0]:
                    best = (price, int(pose), leg_m)
        if best is None:
            return NoPath(NO_WAY)
        route = self._lattice.route(costs, best[1])
        leg_in_m = goals[2][route[-1]]
        points = [np.array(start[:2])]
        if best[2]:
            points.append(_ahead(start, best[2]))
        places = self._lattice.metres(np.array(route))
        points += [places[k] for k in _corners(route, self._lattice)]
        if leg_in_m and heading is not None:
            points.append(_ahead((goal[0], goal[1], heading), -leg_in_m))
        points.append(np.array(goal[:2]))
        path = self._eased(points, (start[2], heading), best[2], leg_in_m)
        if self._hurries and not self._is_clear(path, start):
            self._hurries = False
            path = self._eased(points, (start[2], heading), best[2], leg_in_m)
        return path if self._is_clear(path, start) else NoPath(NO_WAY)

    def _is_clear(self, path: Path, start: Pose) -> bool:
        turns_m = self._turns_m(path, start[2]) + _TURNS_NEARER_M
        return min(path.clearance_m, turns_m) >= self._least_m(start)

    def _turns_m(self, path: Path, before_rad: float) -> float:
        """Least clearance in the turns on the spot of a path."""
        least_m = math.inf
        for k, at in enumerate(path.points_m):
            leg = path.points_m[k + 1] - at if k + 1 < len(path.points_m) else None
            if leg is None:
                after_rad = path.heading_rad
            elif float(np.hypot(*leg)) < NO_LEG_M:
                after_rad = None
            else:
                backward_rad = math.pi if path.backward and not k else 0.0
                after_rad = math.atan2(leg[1], leg[0]) + backward_rad
            if after_rad is None:
                continue
            if path.bend(k) is None:
                pose = float(at[0]), float(at[1]), before_rad
                clear = self._costmap.clearance_m(*turn_poses(pose, after_rad, 0.0))
                least_m = min(least_m, float(clear.min(initial=math.inf)))
            before_rad = after_rad
        return least_m

    def _least_m(self, start: Pose) -> float:
        """Least clearance of a smoothed path; less for a chair that stands within a wide margin."""
        least_m = LEAST_M - 0.02
        here_m = float(self._costmap.clearance_m(*(np.array([one]) for one in start))[0])
        within = least_m - self._costmap.wider_m <= here_m < least_m
        return here_m - float(self._costmap.cell_m) if within else least_m

    def _eased(self, points: list[FloatArray], rads: Headings, leg_m: float, in_m: float) -> Path:
        """Smoothed; if not easy, also tried without what the lattice prices only roughly.

        That is the straight legs at both ends, of `leg_m` and `in_m`, and the last centimetres,
        which the board may refuse.
        """
        path = self._smoothed(points, rads, leg_m, 1 + (in_m > 0.0))
        if leg_m and not path.is_easy:
            at_once = self._smoothed([points[0], *points[2:]], rads, 0.0, 1 + (in_m > 0.0))
            if at_once.cost_s < path.cost_s:
                path, points, leg_m = at_once, [points[0], *points[2:]], 0.0
        if path.is_easy:
            return path
        if in_m:
            other = self._smoothed([*points[:-2], points[-1]], rads, leg_m, 1)
            return min(path, other, key=lambda one: one.cost_s)
        short = self._smoothed(points[:-1], rads, leg_m, 1)
        off_m = float(np.hypot(*(points[-2] - points[-1])))
        return short if short.cost_s + _SHORT_S_PER_M * off_m < path.cost_s else path

    def _smoothed(
        self, points: list[FloatArray], rads: Headings, leg_m: float, fixed_end: int
    ) -> Path:
        """`leg_m`: length of the straight first leg, negative backward; 0: there is none."""
        fixed = 1 + (leg_m != 0.0)
        smooth = self._smoother(rads, leg_m < 0.0)
        found, clear, cost_s = smooth(
            _merged(points, fixed, fixed_end), fixed, fixed_end, not self._hurries
        )
        return Path(found, rads[1], leg_m < 0.0, clear, cost_s, smooth.bends(found))

    def _ends(
        self, x_m: float, y_m: float, heading: float | None
    ) -> tuple[IntArray, IntArray, dict[int, float]]:
        """Lattice poses from which the goal is reached, their prices, and the leg from each."""
        legs: dict[int, float] = {}
        prices: dict[int, int] = {}
        here = np.array([x_m]), np.array([y_m])
        for leg_m in _LEG_STEPS_M if heading is not None else (0.0,):
            if heading is None:
                found = self._lattice.near(x_m, y_m, 0.0, _GOAL_M, 4.0)
            else:
                along = np.arange(0.0, leg_m + 0.01, ALONG_M)
                x, y = x_m - along * math.cos(heading), y_m - along * math.sin(heading)
                headings = np.full(len(along), heading)
                if self._costmap.clearance_m(x, y, headings).min() < LEAST_M:
                    break
                around = 4.0 if leg_m else _SNAP_RAD
                at = float(x[-1]), float(y[-1]), heading
                found = self._lattice.near(*at, _GOAL_M, around)
                found = found[self._turn_fits(found, at)]
                if not leg_m and self._turns_freely(x_m, y_m):
                    found = self._lattice.near(x_m, y_m, heading, _GOAL_M, 4.0)
            for pose in found:
                off = 0.0
                if heading is not None:
                    off = abs(
                        math.remainder(self._lattice.heading_rad(pose) - heading, 2.0 * math.pi)
                    )
                apart = self._lattice.metres(np.array([pose]))[0] - (
                    here[0][0] - leg_m * math.cos(heading or 0.0),
                    here[1][0] - leg_m * math.sin(heading or 0.0),
                )
                price = int(70.0 * leg_m + 46.0 * off + (20 if off > 0.05 else 0))
                price += int(100.0 * float(np.hypot(*apart)))
                if price < prices.get(int(pose), UNREACHED):
                    prices[int(pose)], legs[int(pose)] = price, leg_m
        poses = np.array(list(prices), dtype=np.int64)
        return poses, np.array(list(prices.values()), dtype=np.int64), legs

    def _turn_fits(self, poses: IntArray, at: Pose) -> BoolArray:
        """Whether turns on the spot from the headings of lattice poses to the pose `at` fit."""
        off = half_turn_rad(
            np.array([self._lattice.heading_rad(int(pose)) - at[2] for pose in poses])
        )
        fits = np.abs(off) <= _SNAP_RAD
        turned = np.arange(0.0, math.pi, _ROUND_RAD)
        x, y = np.array(at[0]), np.array(at[1])
        for side in (1.0, -1.0):
            clear = self._costmap.clearance_m(x, y, at[2] + side * turned)
            free_rad = turned[clear < LEAST_M].min(initial=math.inf)
            fits |= (side * off >= 0.0) & (side * off < free_rad)
        return fits

    def _turns_freely(self, x_m: float, y_m: float) -> bool:
        around = np.linspace(0.0, 2.0 * math.pi, 72, endpoint=False)
        found = self._costmap.clearance_m(np.full(72, x_m), np.full(72, y_m), around)
        return bool(found.min() > TURN_EASY_M)

    def _starts(self, start: Pose) -> list[tuple[IntArray, float, float]]:
        """Lattice poses to begin at, the straight leg to them (negative backward), its seconds."""
        found = []
        clear = self._costmap.clearance_m(*(np.array([one]) for one in start))[0]
        if clear < -0.15 - self._costmap.wider_m:
            return []
        least = min(LEAST_M, float(clear) - 0.01)
        here = np.array(start[:2])
        no_turn = turn_refused(self._refused, here)
        for sign in (1.0, -1.0) if self._may_reverse else (1.0,):
            refused = 0.0
            if sign > 0.0:
                refused = refused_s(self._refused, here, start[2])
            for leg_m in _LEG_STEPS_M[1:] if sign < 0.0 else _LEG_STEPS_M:
                along = sign * np.arange(0.0, leg_m + 0.01, ALONG_M)
                x, y = start[0] + along * math.cos(start[2]), start[1] + along * math.sin(start[2])
                if self._costmap.clearance_m(x, y, np.full(len(x), start[2])).min() < least:
                    break
                aligned_rad = 0.2 if no_turn and abs(leg_m) < NO_TURN_M else 0.42
                poses = self._lattice.near(float(x[-1]), float(y[-1]), start[2], 0.12, aligned_rad)
                if len(poses):
                    leg_s = refused + self._first_leg_s(start, sign * leg_m) if leg_m else 0.0
                    found.append((poses, sign * leg_m, leg_s))
        return found

    def _first_leg_s(self, start: Pose, leg_m: float) -> float:
        """Seconds of the first leg, priced as in whole paths; backward counts twice."""
        backward = leg_m < 0.0
        first = Smoother(self._costmap, start[2], None, backward, ())
        leg_s = first.first_leg_s(np.array(start[:2]), _ahead(start, leg_m))
        return leg_s * (2.0 if backward else 1.0)


def _ahead(pose: Pose, leg_m: float) -> FloatArray:
    return np.array((pose[0] + leg_m * math.cos(pose[2]), pose[1] + leg_m * math.sin(pose[2])))


def _corners(route: list[int], lattice: Lattice) -> list[int]:
    """Indices in `route` of its ends, and of each change of heading."""
    headings = [lattice.heading_rad(pose) for pose in route]
    found = [0]
    found += [k for k in range(1, len(route)) if headings[k] != headings[k - 1]]
    found.append(len(route) - 1)
    return sorted(set(found))


def _merged(points: list[FloatArray], fixed: int, fixed_end: int) -> list[FloatArray]:
    """The vertices without those within 10 cm of a fixed one, and without repetitions."""
    first, last = points[:fixed], points[-fixed_end:]
    middle = [
        one
        for one in points[fixed : len(points) - fixed_end]
        if all(float(np.hypot(*(one - other))) > 0.1 for other in (*first[-1:], *last[:1]))
    ]
    kept: list[FloatArray] = []
    for one in middle:
        if not kept or float(np.hypot(*(one - kept[-1]))) > 1e-9:
            kept.append(one)
    return [*first, *kept, *last]
