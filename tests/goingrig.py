"""Floors made of boxes, a simulated chair without a board that drives on them, plans that wait."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint, Margins
from gazechair.base.poses import to_frame
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import Costmap
from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import Mission
from gazechair.going.path import Abandoned
from gazechair.going.plan import Planner, Pose
from gazechair.going.planning import Planned
from gazechair.going.rolled import Located
from gazelink.settings_table import TABLE
from gazesim.chair import Chair

CELL_M = 0.025
PERSON_M = 0.15
TOUCHES_M = -0.03
"""Less clearance than any error of the map explains: the chair has driven into something."""
Box = tuple[float, float, float, float]  # x0, y0, x1, y1

TWO_ROOMS: tuple[Box, ...] = ((3.95, 0.0, 4.05, 1.45), (3.95, 2.45, 4.05, 4.0))
"""A wall with a door of 1 m in the middle of 8 m by 4 m."""


def floor(
    boxes: Sequence[Box] = (),
    size_m: tuple[float, float] = (8.0, 4.0),
    unseen: Sequence[Box] = (),
    no_go: Sequence[FloatArray] = (),
    margins: Margins | None = None,
) -> Costmap:
    """A walled room of `size_m` with boxes in it."""
    nx, ny = (round(one / CELL_M) for one in size_m)
    occupied = np.zeros((nx, ny), dtype=np.bool_)
    occupied[:2], occupied[-2:], occupied[:, :2], occupied[:, -2:] = True, True, True, True
    free = np.ones_like(occupied)
    for into, value, rows in ((occupied, True, boxes), (free, False, unseen)):
        for x0, y0, x1, y1 in rows:
            i0, j0, i1, j1 = (round(one / CELL_M) for one in (x0, y0, x1, y1))
            into[i0:i1, j0:j1] = value
    free &= ~occupied
    return Costmap(occupied, free, CELL_M, np.zeros(2), Footprint(margins=margins), no_go)


def numbers(profile: int = 2) -> ChairNumbers:
    """ChairNumbers of the default settings at full deflection."""
    values = {name: default for name, default, _, _ in TABLE}
    values |= {"profile": profile, "linear_permille": 1000, "turn_permille": 1000}
    return ChairNumbers.of(values)


class GoingChair:
    """Mission and simulated chair; the mission's stick is put out unchanged."""

    def __init__(self, costmap: Costmap, start: Pose) -> None:
        self.mission = Mission(costmap, Planner(costmap), numbers(), Footprint())
        self.chair = Chair("3.1")
        self.chair.place(start[0], start[1], math.degrees(start[2]))
        self.chair.step(0.01, (0.0, 0.0))  # its joystick has been neutral
        self.now_s = 0.0
        self.asked = self.stick = STOP
        self.refuses = False
        self.jammed = False
        """Its wheels do not turn, whatever is put out."""
        self.located = True
        self.wanders_m = 0.0
        """Amplitude by which its pose in the map oscillates."""
        self.least_m = math.inf

    @property
    def pose(self) -> Pose:
        """The true pose."""
        return self.chair.x_m, self.chair.y_m, math.radians(self.chair.heading_deg)

    def run(self, seconds: float) -> str:
        """Run for `seconds`, or until it has arrived; returns the state."""
        end_s = self.now_s + seconds
        while self.now_s < end_s and self.mission.state != "arrived":
            self.step()
        assert self.least_m > TOUCHES_M
        return self.mission.state

    def step(self) -> Stick:
        """Run one period, 50 ms."""
        self.now_s += 0.05
        if self.located:
            moves = self.chair.speed_m_s, self.chair.yaw_rate_deg_s
            x, y, heading = self.pose
            off_m = self.wanders_m * math.sin(self.now_s)
            at = (x + off_m, y - off_m, heading)
            self.mission.locate(Located(at, *moves, self.now_s))
        self.asked = self.stick = self.mission.step(self.now_s, self.stick)
        if self.refuses:
            self.stick = STOP
        moves = STOP if self.jammed else self.stick
        for _ in range(5):
            self.chair.step(0.01, (moves.linear_permille / 1000.0, moves.turn_permille / 1000.0))
        clear = self.mission.costmap.clearance_m(*(np.array([one]) for one in self.pose))
        self.least_m = min(self.least_m, float(clear[0]))
        return self.stick


LIDAR_M = (0.3, 0.0)
LIDAR_RANGE_M = 9.0
Person = tuple[float, float]
"""Position of a person, seen as a disc."""


def scan_of(costmap: Costmap, pose: Pose, persons: Sequence[Person]) -> tuple[FloatArray, ...]:
    """Ends and beginnings of a lidar's beams, in the chair's frame."""
    bearings = np.radians(np.arange(0.0, 360.0, 0.5))
    along = np.stack((np.cos(bearings), np.sin(bearings)), axis=1)
    ranges = np.full(len(along), 0.1)
    hit = np.zeros(len(along), dtype=np.bool_)
    while len(going := np.flatnonzero(~hit & (ranges < LIDAR_RANGE_M))):
        local = np.array(LIDAR_M) + along[going] * ranges[going, None]
        free_m = _free_m(costmap, to_frame(local, np.array(pose)), persons)
        hit[going] = free_m <= 0.0
        # Nothing is nearer than that: no step in between could hit.
        ranges[going] += np.where(hit[going], 0.0, np.maximum(free_m - CELL_M, 0.5 * CELL_M))
    ends = (np.array(LIDAR_M) + along * ranges[:, None])[hit]
    return ends, np.tile(LIDAR_M, (len(ends), 1))


def _free_m(costmap: Costmap, places_m: FloatArray, persons: Sequence[Person]) -> FloatArray:
    """Distance of each place to the nearest box, wall or person; 0 or less within one."""
    cells = np.floor((places_m - costmap.low_m) / CELL_M).astype(np.int64)
    nx, ny = costmap.shape
    free_m = costmap.known_m[np.clip(cells[:, 0], 0, nx - 1), np.clip(cells[:, 1], 0, ny - 1)]
    for x, y in persons:
        off_m = np.hypot(places_m[:, 0] - x, places_m[:, 1] - y) - PERSON_M
        free_m = np.minimum(free_m, off_m)
    return free_m


def drive_among(
    chair: GoingChair, seconds: float, persons: Callable[[float], Sequence[Person]]
) -> list[tuple[str, str]]:
    """Drive until it has arrived, looking ten times a second; states and reasons of each step.

    `persons`: positions of the people at a time, s.
    """
    found = []
    for k in range(round(seconds / 0.05)):
        chair.step()
        if k % 2 == 0:
            points, origins = scan_of(chair.mission.costmap, chair.pose, persons(chair.now_s))
            chair.mission.scan(points, origins, chair.now_s, chair.pose)
        found.append((chair.mission.state, chair.mission.reason))
        if chair.mission.state == "arrived":
            break
    assert chair.least_m > TOUCHES_M
    return found


class Later:
    """Jobs that wait to be run."""

    def __init__(self) -> None:
        self.jobs: list[tuple[Callable[[], Planned], Future[Planned]]] = []

    def submit(self, job: Callable[[], Planned]) -> Future[Planned]:
        self.jobs.append((job, Future()))
        return self.jobs[-1][1]

    def run(self, number: int) -> None:
        """As an executor does."""
        job, found = self.jobs[number]
        try:
            found.set_result(job())
        except Abandoned as error:
            found.set_exception(error)
