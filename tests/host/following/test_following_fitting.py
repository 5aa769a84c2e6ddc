"""The path behind a person, kept clear for the chair: in doorways, and where it cannot pass."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future
from itertools import pairwise

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.base.at_once import at_once
from gazechair.base.footprint import Footprint, distance_m, inside
from gazechair.following.fitting import Fitting, Planned, Submit
from gazechair.following.trail import FREE, Trail

_STEP_S, _FRONT_M = 0.1, 0.65
Place = tuple[float, float]


class Chair:
    """Follows a patient person exactly as requested; everything else consists of walls."""

    def __init__(self, walls: list[tuple[Place, Place]], submit: Submit = at_once) -> None:
        self.points_m = np.concatenate([_line(*wall, step_m=0.02) for wall in walls])
        self.footprint = Footprint()
        self.fitting = Fitting(self.footprint, submit)
        self.trail = Trail(_FRONT_M)
        self.pose = np.zeros(3)
        self.trail.begin(self.pose)
        self.poses: list[FloatArray] = []
        self.at_s = 0.0
        self.fits = True

    def follows(self, way: FloatArray, after: int, blind: bool = False) -> None:
        """`after`: scans at the way's end. `blind`: follow the person's own path."""
        at = 0
        for _ in range(2 * len(way) + after):
            if math.dist(way[at], self.pose[:2]) < _FRONT_M + 1.6:
                at = min(at + 1, len(way) - 1)
            self.scan((float(way[at][0]), float(way[at][1])), blind)

    def scan(self, person: Place, blind: bool = False) -> None:
        self.at_s += _STEP_S
        self.trail.walked(*person)
        room = FREE
        if not blind:
            room = self.fitting.room(self.standing_m, self.trail, self.pose, self.at_s)
        request = self.trail.request(self.pose, *person, _STEP_S, room)
        heading = self.pose[2] + 0.5 * request.yaw_rad_s * _STEP_S
        step = request.linear_m_s * _STEP_S
        moved = step * math.cos(heading), step * math.sin(heading), request.yaw_rad_s * _STEP_S
        self.pose = self.pose + np.array(moved)
        self.poses.append(self.pose)

    def standing_m(self, low_m: FloatArray, high_m: FloatArray) -> FloatArray:
        within = ((self.points_m >= low_m) & (self.points_m <= high_m)).all(axis=1)
        return np.asarray(self.points_m[within])

    def least_m(self) -> float:
        """The least distance to a wall of all poses so far, negative inside."""
        found = math.inf
        for x, y, heading in self.poses:
            c, s = math.cos(heading), math.sin(heading)
            own = (self.points_m - (x, y)) @ np.array(((c, -s), (s, c)))
            far = distance_m(self.footprint.body, own)
            found = min(found, float(np.where(inside(self.footprint.body, own), -far, far).min()))
        return found


def _line(a: Place, b: Place, step_m: float) -> FloatArray:
    count = max(2, round(math.dist(a, b) / step_m) + 1)
    return np.array(a) + (np.array(b) - np.array(a)) * np.linspace(0.0, 1.0, count)[:, None]


def _walk(*corners: Place) -> FloatArray:
    return np.concatenate([_line(a, b, 0.04) for a, b in pairwise(corners)])


def _door(width_m: float, at_x_m: float = 3.0) -> list[tuple[Place, Place]]:
    """A wall across the way, 10 cm thick, with a door in it around y = 0."""
    half, x0, x1 = 0.5 * width_m, at_x_m, at_x_m + 0.1
    walls: list[tuple[Place, Place]] = []
    for side in (1.0, -1.0):
        walls += [((x, side * half), (x, side * 2.5)) for x in (x0, x1)]
        walls.append(((x0, side * half), (x1, side * half)))
    return walls


WAYS = {
    "turns right behind the door": ((1.9, 0.0), (3.3, 0.0), (3.3, -2.5)),
    "hugs a jamb": ((1.9, 0.0), (2.6, 0.25), (3.6, 0.25), (6.0, 0.3)),
    "comes to the door slantwise": ((1.9, 0.9), (2.6, 0.6), (3.6, -0.6), (4.6, -1.8)),
}


@pytest.mark.parametrize("name", WAYS)
def test_keeps_clear_of_a_doorway_that_the_person_cuts(name: str) -> None:
    way = _walk(*WAYS[name])
    blind, chair = Chair(_door(0.95)), Chair(_door(0.95))
    blind.follows(way, 100, blind=True)
    assert blind.least_m() < 0.0  # on the person's own path it would touch
    chair.follows(way, 100)
    assert chair.least_m() > 0.02
    assert math.dist(chair.pose[:2], way[-1]) < _FRONT_M + 1.6
    assert chair.pose[0] > 2.9


def test_a_path_that_is_clear_is_not_replaced() -> None:
    request: list[object] = []

    def submit(job: Callable[[], Planned | None]) -> Future[Planned | None]:
        request.append(job)
        return at_once(job)

    chair = Chair(_door(1.2), submit)
    chair.follows(_walk((1.9, 0.0), (6.0, 0.0)), 60)
    assert not request
    assert chair.pose[0] > 3.9


def test_stands_before_a_gap_that_is_too_narrow_and_says_so() -> None:
    chair = Chair(_door(0.70))
    chair.follows(_walk((1.9, 0.0), (4.5, 0.0)), 40)
    assert chair.least_m() > 0.0
    assert chair.pose[0] + _FRONT_M < 3.0
    assert not chair.fitting.fits
    for _ in range(80):  # the person comes back, and leaves another way
        chair.scan((float(chair.pose[0]) + 1.0, 0.0))
    chair.follows(_walk((2.9, 0.0), (2.3, 1.0), (2.3, 2.2)), 60)
    assert chair.fitting.fits
    assert chair.least_m() > 0.0


def test_does_not_turn_to_the_person_where_the_chair_has_no_room_to_turn() -> None:
    """In the doorway, with the person round the corner."""
    chair = Chair(_door(0.95))
    chair.pose = np.array((2.9, 0.0, 0.0))
    chair.trail.begin(chair.pose)
    for k in range(60):
        angle = min(0.03 * k, 0.9)
        chair.scan((2.9 + 1.8 * math.cos(angle), -1.8 * math.sin(angle)))
    assert abs(chair.pose[2]) < math.radians(10.0)
    assert chair.least_m() > 0.02


def test_stands_while_it_waits_for_a_path_which_begins_where_it_comes_to_rest() -> None:
    jobs: list[tuple[Callable[[], Planned | None], Future[Planned | None]]] = []

    def submit(job: Callable[[], Planned | None]) -> Future[Planned | None]:
        if jobs:
            return at_once(job)
        jobs.append((job, Future()))
        return jobs[0][1]

    chair = Chair(_door(0.95), submit)
    way = _walk(*WAYS["turns right behind the door"])
    at = 0
    while not jobs:
        at += math.dist(way[at], chair.pose[:2]) < _FRONT_M + 1.6
        chair.scan((float(way[at][0]), float(way[at][1])))
    for _ in range(15):
        chair.scan((float(way[at][0]), float(way[at][1])))
    speeds = np.hypot(*np.diff(np.array(chair.poses)[-4:, :2], axis=0).T) / _STEP_S
    assert speeds.max() < 1e-9
    job, answer = jobs[0]
    found = job()
    assert found is not None
    assert math.dist(found[0][0][:2], chair.pose[:2]) < 0.15
    answer.set_result(found)
    chair.follows(way[at:], 150)
    assert chair.least_m() > 0.02
    assert chair.pose[0] > 2.9
