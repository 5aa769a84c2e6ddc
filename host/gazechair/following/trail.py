"""Requests the motion that keeps 1.2 m behind a person, along the path that they walked.

Through a door the chair takes their path, not the straight line; where it does not fit there, its
own (`fitting.py`). It never drives backward. Distances are from the chair's front.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.following.request import CAP_M_S, STOP, Request
from gazechair.going.rolled import along
from gazechair.going.smooth import Pose

KEEP_M, NEAR_M = 1.2, 1.0
ACCELERATE_M_S2, BRAKE_M_S2 = 0.3, 0.5
"""Limits of the request's change; a person who is near, lost or unsure ends it at once."""
_TURN_RAD_S, _TURN_RAD_S2 = math.radians(35.0), math.radians(90.0)
_PER_S = 0.8  # speed per metre of gap
_TURNS_PER_S = 1.4
STEP_M = 0.06
"""Distance between the path's points."""
_LONGEST = 300
_CUT_M, _CUT_LEAST = 0.35, 12
_LOOK_M = 0.45
_TURN_FIRST_RAD, _DRIVE_AGAIN_RAD = math.radians(24.0), math.radians(6.0)
_EXACTLY_RAD = math.radians(2.5)  # the same, after a corner
_FACE_RAD, _FACED_RAD = math.radians(12.0), math.radians(4.0)
_FULL_TURN_RAD = math.radians(60.0)
_AT_CORNER_M, _TO_CORNER_PER_S, _TO_CORNER_M_S = 0.02, 1.0, 0.06
_LATE_S = 0.35  # from a request until the chair obeys it
_EXPECT_M, _EXPECT_RAD, _EXPECT_MOST = 0.08, math.radians(10.0), 100
_EXPECT_TURN = _TURNS_PER_S * _EXPECT_M / CAP_M_S  # share of the error steered in a step


class Point(NamedTuple):
    """A point of the path, in metres."""

    x_m: float
    y_m: float
    corner_rad: float | None = None
    """Heading with which the drive axle arrives here, to turn on the spot; None: no corner."""


class Room(NamedTuple):
    """What the chair may do where it is, so that it stays clear of what stands there."""

    ahead_m: float = math.inf
    """How far it may drive along the path."""
    turns: bool = True
    """Whether it may turn on the spot to the path's direction."""
    faces: bool = True
    """Whether it may turn on the spot to the person."""


FREE = Room()


class Trail:
    """The person's path, which the chair follows. `front_m`: from the drive axle to the front."""

    def __init__(self, front_m: float) -> None:
        self._front_m = front_m
        self._points: list[Point] = []
        self._last = STOP
        self._turns = self._exactly = False
        self._faces = False

    def begin(self, pose: FloatArray) -> None:
        """Begin a new path at the chair."""
        self._points = [Point(float(pose[0]), float(pose[1]))]
        self._turns = self._exactly = self._faces = False

    def walked(self, x_m: float, y_m: float) -> None:
        """The person is at (x, y) now. Walking back shortens the path."""
        far_m = math.dist(self._points[-1][:2], (x_m, y_m))
        if far_m < STEP_M:
            return
        for k, point in enumerate(self._points[1:-_CUT_LEAST], 1):
            if math.dist(point[:2], (x_m, y_m)) < _CUT_M:
                del self._points[k + 1 :]
                break
        (x, y), steps = self._points[-1][:2], max(1, round(far_m / STEP_M))
        for k in range(1, steps + 1):
            self._points.append(Point(x + (x_m - x) * k / steps, y + (y_m - y) * k / steps))
        del self._points[:-_LONGEST]

    def stop(self) -> Request:
        """Request a stop at once."""
        self._last, self._turns, self._exactly, self._faces = STOP, False, False, False
        return STOP

    def coast(self, dt_s: float) -> Request:
        """The person was not seen in this scan: request a stop, so that the chair brakes at once
        if they stay hidden. If the next scan shows them, it goes on from the remaining speed.
        """
        self._last = Request(max(0.0, self._last.linear_m_s - BRAKE_M_S2 * dt_s), 0.0)
        return STOP

    def request(
        self, pose: FloatArray, x_m: float, y_m: float, dt_s: float, room: Room = FREE
    ) -> Request:
        """The request that keeps behind the person at (x, y)."""
        here = (float(pose[0]), float(pose[1]))
        far_m = math.dist(here, (x_m, y_m))
        gap_m = far_m - self._front_m - KEEP_M
        linear = min(CAP_M_S, _PER_S * max(0.0, gap_m))
        if linear > 0.0:
            off, corner_m = self._course(here, float(pose[2]))
            self._faces = False
            if self._turns:
                linear = 0.0
            to_corner = max(_TO_CORNER_M_S, _TO_CORNER_PER_S * corner_m)
            linear = min(linear, to_corner, _PER_S * room.ahead_m)
            linear *= max(0.2, 1.0 - abs(off) / _FULL_TURN_RAD)
            moves = room.turns if self._turns else linear > 0.0
            yaw = _TURNS_PER_S * off if moves else 0.0
        else:
            off = _off((*here, float(pose[2])), (x_m, y_m))
            self._turns = False
            self._faces = abs(off) > (_FACED_RAD if self._faces else _FACE_RAD)
            yaw = _TURNS_PER_S * off if self._faces and room.faces else 0.0
        yaw = max(-_TURN_RAD_S, min(_TURN_RAD_S, yaw))
        return self._bounded(linear, yaw, dt_s, far_m - self._front_m < NEAR_M)

    # -- the path ----------------------------------------------------------------------------------

    @property
    def points(self) -> Sequence[Point]:
        """From near the chair to the person."""
        return self._points

    @property
    def places_m(self) -> FloatArray:
        """(N, 2): x and y of `points`."""
        return np.array([one[:2] for one in self._points])

    def take(self, points: Sequence[Point], end: Point) -> None:
        """Drive along `points`, and from `end`, a point of the path, on along the path."""
        after = self._points.index(end) + 1 if end in self._points else len(self._points)
        self._points = [*points, *self._points[after:]]
        self._turns = self._exactly = False

    def rest(self, pose: FloatArray) -> Pose:
        """Where the chair comes to rest if it is requested to stop now."""
        speed, rate = self._last.linear_m_s, self._last.yaw_rad_s
        way_m = speed * _LATE_S + 0.5 * speed**2 / BRAKE_M_S2
        return along((float(pose[0]), float(pose[1]), float(pose[2])), way_m, rate * _LATE_S)

    def expected(self, pose: FloatArray, far_m: float) -> FloatArray:
        """Rows (N, 4): x, y, heading, metres ahead: poses along the path, turns too."""
        ghost = copy.copy(self)
        ghost._points = list(self._points)
        x, y, heading = (float(one) for one in pose)
        rows, ahead_m = [(x, y, heading, 0.0)], 0.0
        while ahead_m < far_m and len(rows) < _EXPECT_MOST:
            off, _ = ghost._course((x, y), heading)
            if len(ghost._points) < 2:
                break
            if ghost._turns:
                heading += max(-_EXPECT_RAD, min(_EXPECT_RAD, off))
            else:
                share = min(1.0, _EXPECT_TURN / max(0.2, 1.0 - abs(off) / _FULL_TURN_RAD))
                heading += share * off
                x, y = x + _EXPECT_M * math.cos(heading), y + _EXPECT_M * math.sin(heading)
                ahead_m += _EXPECT_M
            rows.append((x, y, heading, ahead_m))
        return np.array(rows)

    def _bounded(self, linear: float, yaw: float, dt_s: float, near: bool) -> Request:
        before = self._last
        up, down, turn = ACCELERATE_M_S2 * dt_s, BRAKE_M_S2 * dt_s, _TURN_RAD_S2 * dt_s
        linear = max(before.linear_m_s - down, min(before.linear_m_s + up, linear))
        if near:
            linear = 0.0
        yaw = max(before.yaw_rad_s - turn, min(before.yaw_rad_s + turn, yaw))
        self._last = Request(linear, yaw)
        return self._last

    def _course(self, here: tuple[float, float], heading_rad: float) -> tuple[float, float]:
        """Angle to the path's direction, radians, and metres to its next corner."""
        self._forget(here)
        aim, corner_m = self._ahead(here)
        if corner_m < _AT_CORNER_M:
            corner = next(k for k, one in enumerate(self._points) if one.corner_rad is not None)
            x_m, y_m, _ = self._points[corner]
            self._points[: corner + 1] = [Point(x_m, y_m)]
            self._turns = self._exactly = True
            aim, corner_m = self._ahead(here)
        off = _off((*here, heading_rad), aim)
        again = _EXACTLY_RAD if self._exactly else _DRIVE_AGAIN_RAD
        self._turns = abs(off) > (again if self._turns else _TURN_FIRST_RAD)
        self._exactly = self._exactly and self._turns
        return off, corner_m

    def _forget(self, here: tuple[float, float]) -> None:
        """Drop all points before the one of the first 1.5 m that is nearest to the chair."""
        along, nearest, best = 0.0, 0, math.inf
        for k, point in enumerate(self._points):
            along += math.dist(self._points[k - 1][:2], point[:2]) if k else 0.0
            if along > 1.5:
                break
            if math.dist(point[:2], here) < best:
                nearest, best = k, math.dist(point[:2], here)
            if point.corner_rad is not None:
                break
        del self._points[:nearest]

    def _ahead(self, here: tuple[float, float]) -> tuple[tuple[float, float], float]:
        """The first place of the path that is far enough away to steer towards, and metres to the
        next corner; inf: that is farther.
        """
        for point in self._points:
            if point.corner_rad is not None:
                c, s = math.cos(point.corner_rad), math.sin(point.corner_rad)
                left_m = c * (point.x_m - here[0]) + s * (point.y_m - here[1])
                beyond_m = max(0.0, _LOOK_M - left_m)
                return (point.x_m + c * beyond_m, point.y_m + s * beyond_m), left_m
            if math.dist(point[:2], here) >= _LOOK_M:
                return point[:2], math.inf
        return self._points[-1][:2], math.inf


def _off(pose: tuple[float, float, float], point: tuple[float, float]) -> float:
    """Angle by which the chair must turn to face `point`, radians."""
    angle = math.atan2(point[1] - pose[1], point[0] - pose[0]) - pose[2]
    return math.remainder(angle, 2.0 * math.pi)
