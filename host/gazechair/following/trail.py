"""Requests the motion that keeps 1.2 m behind a person, along the path that they walked.

Through a door the chair takes their path, not the straight line. It never drives backward.
Distances are from the chair's front. Obstacles are left to the board.
"""

from __future__ import annotations

import math

from gazechair.base.footprint import FloatArray
from gazechair.following.request import CAP_M_S, STOP, Request

KEEP_M, NEAR_M = 1.2, 1.0
ACCELERATE_M_S2, BRAKE_M_S2 = 0.3, 0.5
"""Limits of the request's change; a person who is near, lost or unsure ends it at once."""
_TURN_RAD_S, _TURN_RAD_S2 = math.radians(35.0), math.radians(90.0)
_PER_S = 0.8  # speed per metre of gap
_TURNS_PER_S = 1.4
_STEP_M = 0.06
_LONGEST = 300
_CUT_M, _CUT_LEAST = 0.35, 12
_LOOK_M = 0.45
_TURN_FIRST_RAD, _DRIVE_AGAIN_RAD = math.radians(24.0), math.radians(6.0)
_FACE_RAD, _FACED_RAD = math.radians(12.0), math.radians(4.0)
_FULL_TURN_RAD = math.radians(60.0)


class Trail:
    """The person's path, which the chair follows. `front_m`: from the drive axle to the front."""

    def __init__(self, front_m: float) -> None:
        self._front_m = front_m
        self._points: list[tuple[float, float]] = []
        self._last = STOP
        self._turns = False
        self._faces = False

    def begin(self, pose: FloatArray) -> None:
        """Begin a new path at the chair."""
        self._points = [(float(pose[0]), float(pose[1]))]
        self._turns = self._faces = False

    def walked(self, x_m: float, y_m: float) -> None:
        """The person is at (x, y) now. Walking back shortens the path."""
        far_m = math.dist(self._points[-1], (x_m, y_m))
        if far_m < _STEP_M:
            return
        for k, point in enumerate(self._points[1:-_CUT_LEAST], 1):
            if math.dist(point, (x_m, y_m)) < _CUT_M:
                del self._points[k + 1 :]
                break
        (x, y), steps = self._points[-1], max(1, round(far_m / _STEP_M))
        for k in range(1, steps + 1):
            self._points.append((x + (x_m - x) * k / steps, y + (y_m - y) * k / steps))
        del self._points[:-_LONGEST]

    def stop(self) -> Request:
        """Request a stop at once."""
        self._last, self._turns, self._faces = STOP, False, False
        return STOP

    def coast(self, dt_s: float) -> Request:
        """The person was not seen in this scan: request a stop, so that the chair brakes at once
        if they stay hidden. If the next scan shows them, it goes on from the remaining speed.
        """
        self._last = Request(max(0.0, self._last.linear_m_s - BRAKE_M_S2 * dt_s), 0.0)
        return STOP

    def request(self, pose: FloatArray, x_m: float, y_m: float, dt_s: float) -> Request:
        """The request that keeps behind the person at (x, y)."""
        here = (float(pose[0]), float(pose[1]))
        self._forget(here)
        far_m = math.dist(here, (x_m, y_m))
        gap_m = far_m - self._front_m - KEEP_M
        linear = min(CAP_M_S, _PER_S * max(0.0, gap_m))
        if linear > 0.0:
            off = _off(pose, self._ahead(here))
            self._turns = abs(off) > (_DRIVE_AGAIN_RAD if self._turns else _TURN_FIRST_RAD)
            self._faces = False
            if self._turns:
                linear = 0.0
            linear *= max(0.2, 1.0 - abs(off) / _FULL_TURN_RAD)
            yaw = _TURNS_PER_S * off
        else:
            off = _off(pose, (x_m, y_m))
            self._turns = False
            self._faces = abs(off) > (_FACED_RAD if self._faces else _FACE_RAD)
            yaw = _TURNS_PER_S * off if self._faces else 0.0
        yaw = max(-_TURN_RAD_S, min(_TURN_RAD_S, yaw))
        return self._bounded(linear, yaw, dt_s, far_m - self._front_m < NEAR_M)

    def _bounded(self, linear: float, yaw: float, dt_s: float, near: bool) -> Request:
        before = self._last
        up, down, turn = ACCELERATE_M_S2 * dt_s, BRAKE_M_S2 * dt_s, _TURN_RAD_S2 * dt_s
        linear = max(before.linear_m_s - down, min(before.linear_m_s + up, linear))
        if near:
            linear = 0.0
        yaw = max(before.yaw_rad_s - turn, min(before.yaw_rad_s + turn, yaw))
        self._last = Request(linear, yaw)
        return self._last

    def _forget(self, here: tuple[float, float]) -> None:
        """Drop all points before the one of the first 1.5 m that is nearest to the chair."""
        along, nearest, best = 0.0, 0, math.inf
        for k, point in enumerate(self._points):
            along += math.dist(self._points[k - 1], point) if k else 0.0
            if along > 1.5:
                break
            if math.dist(point, here) < best:
                nearest, best = k, math.dist(point, here)
        del self._points[:nearest]

    def _ahead(self, here: tuple[float, float]) -> tuple[float, float]:
        """The first point of the path that is far enough away to steer towards."""
        for point in self._points:
            if math.dist(point, here) >= _LOOK_M:
                return point
        return self._points[-1]


def _off(pose: FloatArray, point: tuple[float, float]) -> float:
    """Angle by which the chair must turn to face `point`, radians."""
    angle = math.atan2(point[1] - pose[1], point[0] - pose[0]) - float(pose[2])
    return math.remainder(angle, 2.0 * math.pi)
