"""Scenes for the whole chair: generated homes, ROS maps, and ways that become blocked."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.stored import ros_map as product_maps
from gazelink.settings_table import PROFILES
from gazemeasure import carmen_log
from gazemeasure.go import foreign_maps, missions, rows
from gazemeasure.go import record as go_record
from gazemeasure.go.whole import Driven, Judge, Scene, drive
from gazemeasure.home.localization import KEY_SIGMAS, look, mapped
from gazemeasure.on_record import Job
from gazemeasure.report import Report
from gazesim import home_plans, ros_map
from gazesim.home_drive import FRONT, REAR
from gazesim.home_routes import Router
from gazesim.homes import Home, Walker
from gazesim.rooms import Door, box

WHOLE, DRAWN, ROBOT, DOOR, PERSON, ROUND = (
    "whole firmware", "ROS map drawn by hand", "ROS map left by a robot",
    "the only door closes", "a person stands in the only door", "one of two doors closes",
)  # fmt: skip
KINDS = {WHOLE: 100, DRAWN: 20, ROBOT: 20, DOOR: 20, PERSON: 20, ROUND: 20}
"""How many of each the whole set has."""
SHUT = (DOOR, PERSON, ROUND)
_LEAST_ARRIVED = {WHOLE: 99.0, DRAWN: 99.0, ROBOT: 99.0, DOOR: 95.0, PERSON: 95.0, ROUND: 95.0}
_REPORTED_S = 10.0
_QUICK = 2
_ROOM_M = 1.5  # nothing is blocked nearer to the chair
_LOOK_MS = 50
_SHUTS_M = 0.6  # distance travelled before that, at most
_SHUT_S = 20.0  # until it opens, after the pages were told
_WALL_X_M = 4.0
_KEYS_M = 0.6  # from one key scan of a map to the next


D = TypeVar("D", bound="Done")


@dataclass(frozen=True)
class Done:
    """A mission of the whole chair and its result."""

    job: Job
    driven: Driven

    @property
    def arrived(self) -> bool:
        """True if the chair arrived, by the truth."""
        return self.driven.arrived

    @property
    def collisions(self) -> int:
        """Number of collisions, by the truth."""
        return self.driven.collisions

    @property
    def ratio(self) -> float:
        """Time divided by the ideal time."""
        return self.driven.ratio

    @property
    def why(self) -> str:
        """Why it did not arrive."""
        return self.driven.why

    @classmethod
    def kept(cls: type[D], row: dict[str, Any]) -> D:
        """A result from its JSON row."""
        return cls(**{**row, "job": Job(**row["job"]), "driven": Driven(**row["driven"])})


def mission(job: Job) -> Done:
    """Drive one mission; returns its result."""
    scene = _MADE[job.kind](job)
    if job.kind in SHUT:
        return Done(job, drive(scene, Shut(job).act))
    return Done(job, drive(scene))


def measure(report: Report, quick: bool, processes: int) -> None:
    """Add the rows of every kind."""
    jobs = [
        Job(kind, seed)
        for kind, count in KINDS.items()
        for seed in range(_QUICK if quick else count)
    ]
    if not carmen_log.is_here(carmen_log.FR079):
        report.note("a ROS map left by a robot: the public log is not on this machine")
        jobs = [job for job in jobs if job.kind != ROBOT]
    file = None if quick else go_record.FILE
    done = go_record.gather(jobs, mission, Done.kept, processes, file)
    for kind in dict.fromkeys(job.kind for job in jobs):
        _add(report, kind, [one.driven for one in done if one.job.kind == kind])
    rows.note_failures(report, done)


def _add(report: Report, kind: str, done: list[Driven]) -> None:
    rows.add_arrived(report, kind, done, _LEAST_ARRIVED[kind])
    rows.add_gap(report, done)
    if kind not in SHUT:
        rows.add_ratio(report, done, rows.RATIO)
    else:
        shut = sum(one.shut for one in done)
        report.add("  ways that were shut", shut, f"of {len(done)}", len(done), at_least=True)
        silent_s = max(one.silent_s for one in done)
        report.add("  stood there before its pages were told why, most", silent_s, "s", _REPORTED_S)


class Shut:
    """Blocks the way during the drive, and opens it again some time after the pages were told."""

    def __init__(self, job: Job) -> None:
        self._kind = job.kind
        self._after_m = float(np.random.default_rng((job.seed, 5)).uniform(0.0, _SHUTS_M))
        self._shut = False
        self._silent_ms: int | None = None
        self._reported_ms: int | None = None

    def act(self, judge: Judge) -> None:
        """Called each millisecond."""
        if not judge.pressed_ms or judge.chair.now_ms % _LOOK_MS:
            return
        now_ms, room = judge.chair.now_ms, judge.scene.room
        x_m, y_m, _ = judge.chair.world.pose
        if not self._shut and self._reported_ms is None:
            made_m = math.dist((x_m, y_m), judge.scene.start[:2])
            far_m = math.dist((x_m, y_m), _middle(room.doors[0]))
            if made_m > self._after_m and far_m > _ROOM_M and x_m < _WALL_X_M:
                self._set(room, True)
                judge.driven.shut = True
        if not self._shut:
            return
        reported = bool(judge.chair.news["reason"])
        if reported and self._reported_ms is None:
            self._reported_ms = now_ms
        if reported or judge.moves:
            self._silent_ms = None
        elif self._silent_ms is None:
            self._silent_ms = now_ms
        else:
            silent_s = (now_ms - self._silent_ms) / 1000.0
            judge.driven.silent_s = max(judge.driven.silent_s, silent_s)
        waited_s = 0.0 if self._reported_ms is None else (now_ms - self._reported_ms) / 1000.0
        if self._kind != ROUND and waited_s > _SHUT_S:
            self._set(room, False)

    def _set(self, room: Home, shut: bool) -> None:
        self._shut = shut
        door = room.doors[0]
        if self._kind != PERSON:
            room.set_door(door.name, not shut)
        else:
            room.people = (Walker((_middle(door),)),) if shut else ()  # whom lidars see


def _middle(door: Door) -> tuple[float, float]:
    return 0.5 * (door.hinge[0] + door.jamb[0]), 0.5 * (door.hinge[1] + door.jamb[1])


def _in_a_home(job: Job) -> Scene:
    number = job.seed // missions.MISSIONS_IN_A_HOME
    return _scene(missions.fenced(number), mapped_inside(number), job)


@lru_cache(maxsize=2)
def mapped_inside(number: int) -> OccupancyGrid:
    """The map of that home, from places that a chair can reach, not from its garden."""
    home, chance = missions.fenced(number), np.random.default_rng((number, 8))
    bare = home_plans.home(number)
    router = Router(bare)
    costs = router.costs_to(*next(iter(bare.places.values())))
    corners = bare.body_segments().reshape(-1, 2)
    (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
    keys = []
    for x in np.arange(x0, x1, _KEYS_M):
        for y in np.arange(y0, y1, _KEYS_M):
            place = router.place(x, y)
            if place is None or math.dist(place, (x, y)) > _KEYS_M:
                continue
            if router.reaches(costs, *place):
                pose = np.array((*place, chance.uniform(-math.pi, math.pi)))
                seen = look(home, pose, chance, (FRONT, REAR))
                known = pose + chance.normal(0.0, KEY_SIGMAS)
                keys.append(KeyScan(known, seen.points_m, seen.origins_m, 0.0, 0.0, 0.0))
    return occupancy_of(keys)


def _scene(home: Home, grid: OccupancyGrid, job: Job) -> Scene:
    chance = np.random.default_rng((job.seed, len(job.kind)))
    start, goal = missions.poses(home, grid, chance, 2, False)
    return Scene(home, grid, start, goal, PROFILES[job.seed % len(PROFILES)])


@lru_cache(maxsize=2)
def _from_ros(kind: str) -> tuple[Home, OccupancyGrid]:
    """The home, and the map as a caretaker would import it. Raises NoDataError."""
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name:
        folder = Path(name)
        if kind == DRAWN:
            home = ros_map.load(foreign_maps.drawn_by_hand(folder, noisy=False))
            path = foreign_maps.drawn_by_hand(folder, noisy=True)
        else:
            path = foreign_maps.left_by_a_robot(folder)
            home = ros_map.load(path)
        return home, product_maps.read(path, "Thuis").grid


def _in_a_ros_map(job: Job) -> Scene:
    home, grid = _from_ros(job.kind)
    return _scene(home, grid, job)


def _through_a_door(job: Job) -> Scene:
    """Two rooms, and one or two doors between them, the nearer of which is closed."""
    chance = np.random.default_rng((job.seed, 3))
    count = 2 if job.kind == ROUND else 1
    deep_m = 4.0 * count
    doors, edges = [], [0.0]
    for k in range(count):
        middle, half = 4.0 * k + chance.uniform(1.4, 2.6), 0.5 * chance.uniform(0.95, 1.10)
        edges += [middle - half, middle + half]
        hinge, jamb = (_WALL_X_M, middle - half), (_WALL_X_M, middle + half)
        doors.append(Door(f"door {k}", hinge, jamb, -1))
    edges.append(deep_m)
    walls = [
        box(_WALL_X_M, 0.5 * (low + high), 0.1, high - low, 0.0, 2.5, "wall")
        for low, high in zip(edges[::2], edges[1::2], strict=True)
    ]
    for _ in range(4):
        x = chance.choice((0.3, 7.7))
        walls.append(box(x, chance.uniform(0.5, deep_m - 0.5), 0.4, 0.8, 0.0, 1.2, "cupboard"))
    corners = ((0.0, 0.0), (8.0, 0.0), (8.0, deep_m), (0.0, deep_m), (0.0, 0.0))
    shell = tuple((*a, *b) for a, b in pairwise(corners))
    home = Home(job.kind, shell, tuple(walls), tuple(doors), start=(1.4, 2.0, 0.0))
    grid = mapped(home, chance)
    y = doors[0].hinge[1] + 0.5
    start = 1.3, float(y + chance.uniform(-0.3, 0.3)), float(chance.uniform(-1.0, 1.0))
    goal = 6.4, float(y + chance.uniform(-0.3, 0.3)), float(chance.uniform(-3.0, 3.0))
    return Scene(home, grid, start, goal, PROFILES[job.seed % len(PROFILES)])


_MADE: dict[str, Callable[[Job], Scene]] = {
    WHOLE: _in_a_home,
    DRAWN: _in_a_ros_map,
    ROBOT: _in_a_ros_map,
    DOOR: _through_a_door,
    PERSON: _through_a_door,
    ROUND: _through_a_door,
}
