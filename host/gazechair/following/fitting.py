"""Keeps the path behind a person clear for the chair, which is wider than they are.

The path is checked with the chair's footprint against what stands there. Where it does not fit,
the planner of drives to a place finds another one, within what the person has walked past.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from functools import partial

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint, distance_m, inside
from gazechair.base.polyline import evenly
from gazechair.following.trail import FREE, KEEP_M, STEP_M, Point, Room, Trail
from gazechair.going.costmap import Costmap
from gazechair.going.outline import outline
from gazechair.going.path import NO_LEG_M, Path
from gazechair.going.plan import GOAL_BLOCKED, Planner, Pose
from gazechair.going.smooth import turn_poses

Planned = tuple[list[Point], Point]
"""A path, and the point of the person's path at which it ends."""
_Place = Sequence[float] | FloatArray
Submit = Callable[[Callable[[], Planned | None]], Future[Planned | None]]
"""Runs the planner, usually on a thread."""

Standing = Callable[[FloatArray, FloatArray], FloatArray]
"""Points (N, 2) of what stands between two corners."""

_CHECK_S = 0.25
_AGAIN_S, _RETRY_S = 1.0, 3.0  # from one plan to the next, if it gave a path and if not
_CLEAR_M = 0.06
"""Clearance with which the person's own path is followed."""
_LESS_M = 0.02  # than planned, by errors of steering
_PASSES_M = 0.02
"""Least clearance with which a planned path is followed."""
_LEAVES_M = 0.004  # less clearance than here, where that is little already
_CHECKED_M = 2.0
_PLANNED_M = 3.5  # of the person's path
_FLOOR_M = 1.2  # what is this near to the person's path may be driven on
_EVERY_M = 0.24
_CELL_M = 0.025
_AWAY_RAD = math.radians(100.0)
_CORNER_RAD = math.radians(4.0)  # a smaller turn is steered while driving
_GOALS_M = 0.3  # from one goal to the next nearer one, if that is blocked
_NEAREST_GOAL_M = 0.4
_BESIDE_M = np.array(
    [
        (r * math.cos(k), r * math.sin(k))
        for r in (0.0, 0.15, 0.3, 0.45)
        for k in np.arange(0.0, 6.2, 0.5)
    ]
)  # where a plan may end, nearest first; too near to be behind a wall
_STOP_M = 0.1  # before where the chair does not fit; more than between expected poses


class Fitting:
    """The room of one chair. `footprint`: its outline; `submit`: see Submit."""

    def __init__(self, footprint: Footprint, submit: Submit) -> None:
        self._footprint, self._submit = footprint, submit
        self._parts = outline(footprint)
        every = np.concatenate(self._parts)
        self._reach_m = float(np.hypot(*every.T).max()) + _CLEAR_M
        self.begin()

    def begin(self) -> None:
        """Begin with another path."""
        self._pending: Future[Planned | None] | None = None
        self._least_m = _CLEAR_M  # of the path that is followed
        self._checked_s = self._again_s = -math.inf
        self._room = FREE
        self.fits = True
        """False: no path has been found on which the chair fits through."""

    def room(self, standing_m: Standing, trail: Trail, pose: FloatArray, at_s: float) -> Room:
        """What the chair may do now; changes `trail` where it does not fit."""
        planned = self._planned(trail, at_s)
        if planned or at_s >= self._checked_s + _CHECK_S:
            self._checked_s = at_s
            self._room = self._checked(standing_m, trail, pose, planned)
            if self._room.ahead_m == math.inf:
                self.fits = True
            else:
                self._seek(standing_m, trail, pose, at_s)
        return self._room

    def _checked(
        self,
        standing_m: Standing,
        trail: Trail,
        pose: FloatArray,
        planned: bool,
    ) -> Room:
        """Where the chair fits along `trail`; `planned`: a planner's answer, not yet checked."""
        walked_m = trail.places_m
        length_m = float(np.hypot(*np.diff(walked_m, axis=0).T).sum())
        rows = trail.expected(pose, min(_CHECKED_M, length_m - KEEP_M))
        facing = turn_poses(_pose(pose), _rad(pose, walked_m[-1]), 0.0)
        poses = np.concatenate((rows[:, :3], np.stack(facing, axis=1)))
        clear = self._clearance_m(poses, standing_m)
        along_m = float(clear[: len(rows)].min())
        if planned:
            self._least_m = max(_PASSES_M, min(_CLEAR_M, along_m - _LESS_M))
        elif along_m >= _CLEAR_M:
            self._least_m = _CLEAR_M
        free = clear >= min(self._least_m, clear[0] - _LEAVES_M)
        faces, free = bool(free[len(rows) :].all()), free[: len(rows)]
        if free.all():
            return Room(faces=faces)
        bad_m = float(rows[int(free.argmin()), 3])
        return Room(max(0.0, bad_m - _STOP_M), bad_m > 0.0, faces)

    def _seek(
        self,
        standing_m: Standing,
        trail: Trail,
        pose: FloatArray,
        at_s: float,
    ) -> None:
        """Have another path planned, unless that is under way or was done just now."""
        if self._pending is None and at_s >= self._again_s:
            rest = trail.rest(pose)
            count = round(_PLANNED_M / STEP_M)
            points, walked_m = trail.points[:count], trail.places_m[:count]
            seen_m = standing_m(*_around(np.concatenate((walked_m, (rest[:2],)))))
            goals = _goals(points)
            plan = partial(_plan, self._footprint, seen_m, walked_m, rest, goals)
            self._pending = self._submit(plan)
        elif self._pending is None:
            self.fits = self._room.ahead_m > 0.0
        if self._pending is not None:  # the path will begin where the chair comes to rest
            self._room = Room(0.0, False, False)

    def _planned(self, trail: Trail, at_s: float) -> bool:
        """Whether the planner has answered; `trail` is then the best path there is."""
        if self._pending is None or not self._pending.done():
            return False
        found, self._pending = self._pending.result(), None
        self._again_s = at_s + (_RETRY_S if found is None else _AGAIN_S)
        if found is not None:
            trail.take(*found)
        return True

    def _clearance_m(self, poses: FloatArray, standing_m: Standing) -> FloatArray:
        """(N,): metres from the outline to the nearest point, negative inside; at most _CLEAR_M."""
        reach_m = self._reach_m
        low_m, high_m = poses[:, :2].min(axis=0) - reach_m, poses[:, :2].max(axis=0) + reach_m
        points_m = standing_m(low_m, high_m)
        off = points_m[None, :, :] - poses[:, None, :2]
        near = np.hypot(off[..., 0], off[..., 1]) < reach_m
        which, off = np.nonzero(near)[0], off[near]
        c, s = np.cos(poses[which, 2]), np.sin(poses[which, 2])
        own = np.stack((c * off[:, 0] + s * off[:, 1], c * off[:, 1] - s * off[:, 0]), axis=1)
        least = np.full(len(poses), _CLEAR_M)
        for part in self._parts:
            far = distance_m(part, own)
            np.minimum.at(least, which, np.where(inside(part, own), -far, far))
        return least


def _plan(
    footprint: Footprint,
    points_m: FloatArray,
    walked_m: FloatArray,
    pose: Pose,
    goals: Sequence[Point],
) -> Planned | None:
    """A path from `pose` to the first of `goals` that is free; None: there is none."""
    costmap = _costmap(footprint, points_m, walked_m, pose)
    planner = Planner(costmap)
    for goal in goals:
        place = _beside(costmap, goal, walked_m[-1])
        if place is None:
            continue
        found = planner.plan(pose, place)
        if isinstance(found, Path):
            fits = found.clearance_m >= 0.0 and _faces(found, place)
            return (_points(found, pose[2]), goal) if fits else None
        if found.reason != GOAL_BLOCKED:
            break
    return None


def _beside(costmap: Costmap, at: Point, onward_m: FloatArray) -> tuple[float, float] | None:
    """The nearest place beside a point of the person's path where the chair fits; None: none.

    Its heading there is from `at` to `onward_m`.
    """
    places_m = _BESIDE_M + np.array(at[:2])
    clear = costmap.clearance_m(places_m[:, 0], places_m[:, 1], _rad(at[:2], onward_m))
    fits = np.flatnonzero(clear >= _CLEAR_M)
    if not len(fits):
        return None
    return float(places_m[fits[0], 0]), float(places_m[fits[0], 1])


def _faces(path: Path, goal: tuple[float, float]) -> bool:
    """Whether the path never leads away from the goal: the lidar in front must see the person."""
    return all(
        abs(_rad(a, b, _rad(a, goal))) < _AWAY_RAD
        for a, b in itertools.pairwise(path.points_m)
        if min(math.dist(a, b), math.dist(a, goal)) > NO_LEG_M
    )


def _rad(a: _Place, b: _Place, from_rad: float = 0.0) -> float:
    """Direction from `a` to `b`, relative to another one."""
    return math.remainder(math.atan2(b[1] - a[1], b[0] - a[0]) - from_rad, 2.0 * math.pi)


def _costmap(
    footprint: Footprint, points_m: FloatArray, walked_m: FloatArray, pose: Pose
) -> Costmap:
    """Only what is near the person's path is floor: the lidars may not see all else."""
    floor_m = np.concatenate((walked_m[:: round(_EVERY_M / STEP_M)], (pose[:2],)))
    low_m, high_m = _around(floor_m)
    nx, ny = (int(one) for one in np.ceil((high_m - low_m) / _CELL_M))
    cells = np.floor((points_m - low_m) / _CELL_M).astype(np.int64)
    cells = cells[((cells >= 0) & (cells < (nx, ny))).all(axis=1)]
    stands = np.zeros((nx, ny), dtype=np.bool_)
    stands[cells[:, 0], cells[:, 1]] = True
    x, y = (low_m[k] + (np.arange(n) + 0.5) * _CELL_M for k, n in enumerate((nx, ny)))
    floor = np.zeros_like(stands)
    for at in floor_m:
        floor |= (x[:, None] - at[0]) ** 2 + (y - at[1]) ** 2 < _FLOOR_M**2
    return Costmap(stands, floor & ~stands, _CELL_M, low_m, footprint)


def _around(walked_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    return walked_m.min(axis=0) - _FLOOR_M, walked_m.max(axis=0) + _FLOOR_M


def _points(path: Path, heading_rad: float) -> list[Point]:
    """The path's points, with a corner where it turns on the spot. `heading_rad`: the chair's."""
    found: list[Point] = [Point(*map(float, path.points_m[0]))]
    for k, (a, b) in enumerate(itertools.pairwise(path.points_m)):
        if math.dist(a, b) < NO_LEG_M:
            continue
        leg_rad = _rad(a, b)
        if abs(math.remainder(leg_rad - heading_rad, 2.0 * math.pi)) > _CORNER_RAD:
            found[-1] = found[-1]._replace(corner_rad=heading_rad)
        bend = path.bend(k + 1)
        end = b if bend is None else bend.begin_m
        along = evenly(np.array((found[-1][:2], end)), STEP_M)[1:]
        heading_rad = leg_rad
        if bend is not None:
            arc = bend.sampled()
            along, heading_rad = np.concatenate((along, arc[1:, :2])), float(arc[-1, 2])
        found += [Point(float(x), float(y)) for x, y in along]
    return found


def _goals(points: Sequence[Point]) -> list[Point]:
    """Where a plan may end, best first: the farthest along the person's path."""
    every = points[:: round(_GOALS_M / STEP_M)]
    return [one for one in reversed(every) if math.dist(one[:2], points[0][:2]) > _NEAREST_GOAL_M]


def _pose(pose: FloatArray) -> Pose:
    return float(pose[0]), float(pose[1]), float(pose[2])
