"""Floors drawn as boxes, and a chair without a board that follows a mission there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gazechair.base.footprint import FloatArray, Footprint
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.costmap import Costmap
from gazechair.going.follow import STOP, Stick
from gazechair.going.mission import Located, Mission
from gazechair.going.plan import Planner, Pose
from gazelink.settings_table import TABLE
from gazesim.chair import Chair

CELL_M = 0.025
Box = tuple[float, float, float, float]  # x0, y0, x1, y1

TWO_ROOMS: tuple[Box, ...] = ((3.95, 0.0, 4.05, 1.45), (3.95, 2.45, 4.05, 4.0))
"""A wall with a door of 1 m in the middle of 8 m by 4 m."""


def floor(
    boxes: Sequence[Box] = (),
    size_m: tuple[float, float] = (8.0, 4.0),
    unseen: Sequence[Box] = (),
    no_go: Sequence[FloatArray] = (),
) -> Costmap:
    """A room of that size with walls round it, and boxes in it."""
    nx, ny = (round(one / CELL_M) for one in size_m)
    occupied = np.zeros((nx, ny), dtype=np.bool_)
    occupied[:2], occupied[-2:], occupied[:, :2], occupied[:, -2:] = True, True, True, True
    free = np.ones_like(occupied)
    for into, value, rows in ((occupied, True, boxes), (free, False, unseen)):
        for x0, y0, x1, y1 in rows:
            i0, j0, i1, j1 = (round(one / CELL_M) for one in (x0, y0, x1, y1))
            into[i0:i1, j0:j1] = value
    free &= ~occupied
    return Costmap(occupied, free, CELL_M, np.zeros(2), Footprint(), no_go)


def numbers(profile: int = 2) -> ChairNumbers:
    """Of the default settings at full deflection."""
    values = {name: default for name, default, _, _ in TABLE}
    values |= {"profile": profile, "linear_permille": 1000, "turn_permille": 1000}
    return ChairNumbers.of(values)


class GoingChair:
    """Mission and twin; whatever the mission asks for is put out."""

    def __init__(self, costmap: Costmap, start: Pose) -> None:
        self.mission = Mission(costmap, Planner(costmap), numbers(), Footprint())
        self.chair = Chair("3.1")
        self.chair.place(start[0], start[1], math.degrees(start[2]))
        self.chair.step(0.01, (0.0, 0.0))  # its joystick has been neutral
        self.now_s = 0.0
        self.asked = self.stick = STOP
        self.refuses = False
        self.located = True
        self.least_m = math.inf

    @property
    def pose(self) -> Pose:
        """The truth."""
        return self.chair.x_m, self.chair.y_m, math.radians(self.chair.heading_deg)

    def run(self, seconds: float) -> str:
        """So long, or until it has arrived; the state."""
        end_s = self.now_s + seconds
        while self.now_s < end_s and self.mission.state != "arrived":
            self.step()
        return self.mission.state

    def step(self) -> Stick:
        """50 ms."""
        self.now_s += 0.05
        if self.located:
            moves = self.chair.speed_m_s, self.chair.yaw_rate_deg_s
            self.mission.locate(Located(self.pose, *moves, self.now_s))
        self.asked = self.stick = self.mission.step(self.now_s, self.stick)
        if self.refuses:
            self.stick = STOP
        for _ in range(5):
            self.chair.step(
                0.01, (self.stick.linear_permille / 1000.0, self.stick.turn_permille / 1000.0)
            )
        x, y, heading = (np.array([one]) for one in self.pose)
        clear = self.mission.costmap.clearance_m(x, y, heading)
        self.least_m = min(self.least_m, float(clear[0]))
        return self.stick
