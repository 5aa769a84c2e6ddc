"""Line follower: from pictures and poses to a request that keeps the drive axle on the line.

Near the chair, where the camera does not see the floor, it remembers the line by odometry. After a
loss the chair stops, and the line must be chosen again.
"""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import DEFAULT_CORNERS
from gazechair.base.polyline import along_m, evenly
from gazechair.base.poses import to_frame
from gazechair.following.line_memory import FrozenPicture, LineMemory
from gazechair.following.line_trace import trace
from gazechair.following.line_view import FAR_M, NOT_SEEN, LineColour, Picture, PlanMaker, chosen
from gazechair.following.request import STOP, Request
from gazechair.picture.floor import FloorCamera

LOST_S = 0.3
"""After this long without a picture, or without the line where it should be: stop."""
GONE_S = 1.0
"""After this long: choose again. Until then the chair stands, and goes on once it sees the line."""
ACCELERATE_M_S2, BRAKE_M_S2 = 0.3, 0.4
"""Limits of the requested speed's change; a lost line ends the request at once."""
_FRONT_M = max(x for x, _ in DEFAULT_CORNERS)
_LEAST_POINTS = 3
_REMEMBERED_M = 1.2  # longest drive without any of the line in view: in a bend, or at its end
_LOOK_M = 0.4
_BEND_M = 1.2  # slows for bends this far ahead
_CURVATURE_M = 0.16
_TURN_FIRST_RAD, _DRIVE_AGAIN_RAD = math.radians(50.0), math.radians(10.0)
_LEAST_RAD_S = math.radians(12.0)  # enough to turn a standing chair
_TURNS_PER_S = 1.2
_LEAST_M_S = 0.08
_BEHIND_M = 1.0
_SAME_M = 0.25
# Between points of the line, also over bridged gaps: the nearest one gives the progress.
_EVEN_M = 0.04
_EXPECTED_POINTS, _ROUND_M = 8, 0.14  # this much of it well in view should be seen
_SHARE = 0.85  # of the chair's turn rate; the rest is left for corrections


class State(Enum):
    """State of the follower; LOST: choose again; ENDED: at the line's end."""

    OFF = "off"
    FOLLOWS = "follows"
    LOST = "lost"
    ENDED = "ended"


class LineFollower:
    """One camera; `choose`, then `look` with every picture and `step` every period."""

    def __init__(
        self,
        camera: FloorCamera,
        most_m_s: float,
        most_rad_s: float,
        delay_s: float,
        front_m: float = _FRONT_M,
    ) -> None:
        """`camera`: for the small pictures. `most_m_s`: highest speed of a request.
        `most_rad_s`: turn rate that both sides reach. `delay_s`: the chair's dead time plus lag.
        `front_m`: from the drive axle to the front.
        """
        self._plans = PlanMaker(camera)
        self._camera = camera
        self._most_m_s = most_m_s
        self._most_rad_s = most_rad_s
        self._delay_s = delay_s
        self._front_m = front_m
        self._colour: LineColour | None = None
        self._line = np.zeros((0, 2))
        """The line in the poses' frame, from behind the chair to the farthest point seen."""
        self._ends = False
        self._seen_s = -math.inf
        self._looked_s = -math.inf
        self._blind_m = 0.0
        self._last = STOP
        self._turns = False
        self._frozen = FrozenPicture()
        self._memory = LineMemory()
        self.state = State.OFF

    @property
    def line_m(self) -> FloatArray:
        """The line, (N, 2), in the poses' frame, for display."""
        return self._line

    def stop(self) -> None:
        """Follow nothing."""
        self.state, self._last = State.OFF, STOP

    def choose(
        self, picture: Picture, pixel: tuple[float, float], pose: FloatArray, at_s: float
    ) -> str:
        """Follow the line at `pixel`; returns "", or the reason key when there is none."""
        self.stop()
        if not self._plans.fits(picture):
            return NOT_SEEN
        plan = self._plans(picture)
        point = self._camera.floor_m(np.array((pixel,), dtype=np.float64))[0]
        if not np.isfinite(point).all():
            return NOT_SEEN
        found = chosen(plan, point)
        if isinstance(found, str):
            return found
        self._colour, start, heading = found
        if math.cos(heading) < 0.0:
            heading += math.pi
        nearer = trace(plan, self._colour, start, heading + math.pi).points_m[::-1]
        farther = trace(plan, self._colour, start, heading)
        seen = np.concatenate((nearer, farther.points_m))
        if len(seen) < _LEAST_POINTS:
            return NOT_SEEN
        # Bridge the gap from the chair to the line's first visible point.
        self._line = to_frame(evenly(np.concatenate((np.zeros((1, 2)), seen)), _EVEN_M), pose)
        self._ends = farther.ended
        self._memory = LineMemory()
        self._memory.keep(to_frame(seen, pose), pose)
        self._seen_s = self._looked_s = at_s
        self._blind_m, self._turns = 0.0, False
        self.state = State.FOLLOWS
        return ""

    def look(self, picture: Picture, pose: FloatArray, at_s: float) -> None:
        """Process a picture; `pose` of the drive axle when taken: x, y, heading in radians."""
        if self.state is not State.FOLLOWS or self._colour is None:
            return
        if not self._plans.fits(picture) or self._frozen.hangs(picture, pose):
            return
        self._looked_s = at_s
        plan = self._plans(picture)
        c, s = math.cos(pose[2]), math.sin(pose[2])
        known = (self._line - pose[:2]) @ np.array(((c, -s), (s, c)))
        nearest = int(np.hypot(*known.T).argmin())
        within = plan.seen(known)
        within[:nearest] = False
        if not within.any():
            return
        self._blind_m = 0.0
        first = int(within.argmax())
        for start in range(first, min(first + 12, len(known)), 4):
            ahead = known[min(start + 2, len(known) - 1)] - known[max(start - 2, 0)]
            found = trace(plan, self._colour, known[start], math.atan2(ahead[1], ahead[0]))
            if len(found.points_m) >= _LEAST_POINTS:
                break
        else:
            return
        seen = to_frame(found.points_m, pose)
        if self._memory.contradicts(seen, pose):
            return
        self._memory.keep(seen, pose)
        self._seen_s = at_s
        kept = np.concatenate((known[:start], found.points_m))
        end = found.points_m[-1]
        beyond = known[start:][np.hypot(*(known[start:] - end).T).argmin() + 1 :]
        if not found.ended and len(beyond) and np.hypot(*(beyond[0] - end)) < _SAME_M:
            kept = np.concatenate((kept, beyond))
        else:
            self._ends = found.ended
        self._line = to_frame(evenly(kept, _EVEN_M), pose)
        self._forget(pose)

    def rest(self, pose: FloatArray, now_s: float) -> None:
        """Call instead of `step` while not pressed: the line can get lost then, too."""
        self._last, self._turns = STOP, False
        if self.state is State.FOLLOWS and self._unseen_s(pose, now_s) > GONE_S:
            self.state = State.LOST

    def step(
        self, pose: FloatArray, speed_m_s: float, rate_rad_s: float, now_s: float, dt_s: float
    ) -> Request:
        """The request for the next `dt_s`."""
        if self.state is not State.FOLLOWS:
            return STOP
        self._blind_m += abs(speed_m_s) * dt_s
        unseen_s = self._unseen_s(pose, now_s)
        if unseen_s > GONE_S or self._blind_m > _REMEMBERED_M:
            self.state, self._last = State.LOST, STOP
            return STOP
        # This request stays active until the next step.
        if unseen_s + dt_s > LOST_S:
            self._last = STOP
            return STOP
        then = self._moved(pose, speed_m_s, rate_rad_s)
        gaps = np.hypot(*(self._line - then[:2]).T)
        nearest = int(gaps.argmin())
        ahead = self._line[nearest:]
        left_m = float(np.hypot(*np.diff(ahead, axis=0).T).sum()) - self._front_m
        if left_m < 0.02:
            self.state, self._last = State.ENDED if self._ends else State.LOST, STOP
            return STOP
        self._last = self._request(then, ahead, left_m, dt_s)
        return self._last

    def _unseen_s(self, pose: FloatArray, now_s: float) -> float:
        """Seconds since the line was seen, or since a picture if none should show it."""
        return now_s - (self._looked_s if self._remembers(pose) else self._seen_s)

    def _remembers(self, pose: FloatArray) -> bool:
        """True if the line should be out of view: it bends away near the chair, or ends there."""
        c, s = math.cos(pose[2]), math.sin(pose[2])
        known = (self._line - pose[:2]) @ np.array(((c, -s), (s, c)))
        known = known[int(np.hypot(*known.T).argmin()) :]
        round_m = np.array((0.0, _ROUND_M))
        beside = (known + round_m, known - round_m)
        seen = self._camera.sees(beside[0]) & self._camera.sees(beside[1])
        seen &= (known[:, 0] > self._plans.near_m) & (known[:, 0] < FAR_M)
        return int(seen.sum()) < _EXPECTED_POINTS

    def _moved(self, pose: FloatArray, speed_m_s: float, rate_rad_s: float) -> FloatArray:
        """The pose at which a request made now takes effect."""
        turned, way = rate_rad_s * self._delay_s, speed_m_s * self._delay_s
        middle = pose[2] + 0.5 * turned
        moved = np.array((way * math.cos(middle), way * math.sin(middle), turned))
        return np.asarray(pose + moved)

    def _request(self, pose: FloatArray, ahead: FloatArray, left_m: float, dt_s: float) -> Request:
        along = along_m(ahead)
        aim = np.array([np.interp(_LOOK_M, along, ahead[:, k]) for k in (0, 1)]) - pose[:2]
        off = math.remainder(math.atan2(aim[1], aim[0]) - pose[2], 2.0 * math.pi)
        self._turns = abs(off) > (_DRIVE_AGAIN_RAD if self._turns else _TURN_FIRST_RAD)
        if self._turns:
            size = min(self._most_rad_s, max(_LEAST_RAD_S, _TURNS_PER_S * abs(off)))
            slow = self._last.linear_m_s - BRAKE_M_S2 * dt_s
            return Request(max(0.0, slow), math.copysign(size, off))
        curvature = 2.0 * math.sin(off) / max(0.2, float(np.hypot(*aim)))
        most = max(abs(curvature), _most_curvature(ahead, along))
        speed = max(_LEAST_M_S, _SHARE * self._most_rad_s / max(most, 1e-6))
        speed = min(self._most_m_s, speed)
        speed = min(speed, math.sqrt(2.0 * BRAKE_M_S2 * 0.6 * max(0.0, left_m)) + 0.02)
        before = self._last.linear_m_s
        speed = max(before - BRAKE_M_S2 * dt_s, min(before + ACCELERATE_M_S2 * dt_s, speed))
        along_m_s = max(speed, min(_LEAST_M_S, self._most_m_s))
        yaw = max(-self._most_rad_s, min(self._most_rad_s, curvature * along_m_s))
        return Request(speed, yaw)

    def _forget(self, pose: FloatArray) -> None:
        """Drop points well behind the chair."""
        gaps = np.hypot(*(self._line - pose[:2]).T)
        nearest = int(gaps.argmin())
        behind = np.flatnonzero(gaps[:nearest] > _BEHIND_M)
        if len(behind):
            self._line = self._line[behind[-1] + 1 :]


def _most_curvature(ahead: FloatArray, along: FloatArray) -> float:
    """The largest curvature within the next _BEND_M, 1/m."""
    at = np.arange(0.0, min(_BEND_M, float(along[-1])) + 1e-9, _CURVATURE_M)
    if len(at) < 3:
        return 0.0
    points = np.column_stack([np.interp(at, along, ahead[:, k]) for k in (0, 1)])
    steps = np.diff(points, axis=0)
    turns = np.diff(np.unwrap(np.arctan2(steps[:, 1], steps[:, 0])))
    return float(np.abs(turns).max()) / _CURVATURE_M
