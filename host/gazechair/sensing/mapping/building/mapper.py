"""Mapper: key scans of one drive, measurements between them, and the poses that fit these best.

Odometry is accurate from one key scan to the next, but drifts. Where the chair returns to a known
place, the newest scans are matched to those made there (loop closure), and all poses are
optimized to fit both.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, from_frame, to_frame
from gazechair.sensing.mapping.building.loops import RANGE_M, agree, agreeing, match
from gazechair.sensing.mapping.building.pose_graph import Edge, optimized

KEY_M = 0.3
KEY_RAD = math.radians(20.0)

_LOOP_AFTER = 25  # key scans: a match to a more recent one is no loop
_LOOP_EVERY = 3  # key scans
_AROUND = 6  # key scans on either side of a place, taken together
_PLACES = 2  # searched for each key scan
_SIGHT_M = 4.0  # within this distance the lidars see enough of a place again
_FINISH_WINDOWS_M = (0.6, 0.3)  # of the searches after the drive, one round each

# Uncertainty of a key scan since the last loop, for the window of the search.
_DRIFT_M, _DRIFT_PER_M, _WIDEST_M = 0.4, 0.02, 3.0
_DRIFT_RAD, _DRIFT_PER_RAD, _DRIFT_RAD_S = math.radians(2.0), 0.01, math.radians(0.01)
STEP_SIGMA_M = 0.03
_STEP_SIGMA_RAD = math.radians(0.3)


@dataclass
class KeyScan:
    """What was seen from one place."""

    pose: FloatArray
    """(3,), in the map; moves as loops are closed."""
    points_m: FloatArray
    """(N, 2), in the chair's frame."""
    origins_m: FloatArray
    """(N, 2): where the lidar that measured each point sits."""
    heading_rad: float
    """By the heading sensor, full turns counted."""
    time_s: float
    driven_m: float
    """Since the drive began."""


class Mapper:
    """Collects key scans; `keys` holds them with their poses, `edges` what was measured."""

    def __init__(self, key_m: float = KEY_M, key_rad: float = KEY_RAD) -> None:
        self.keys: list[KeyScan] = []
        self.edges: list[Edge] = []
        self._key_m, self._key_rad = key_m, key_rad
        self._odometry: FloatArray = np.zeros(3)  # at the newest key scan
        self._tied = 0  # the newest key scan that a loop ties to earlier ones
        self._unconfirmed: list[Edge] = []

    @property
    def loops(self) -> int:
        """How many loops are closed."""
        return sum(edge.loop for edge in self.edges)

    def add(
        self,
        odometry: FloatArray,
        points_m: FloatArray,
        heading_rad: float,
        time_s: float,
        sigma_m: float = STEP_SIGMA_M,
        origins_m: FloatArray | None = None,
    ) -> bool:
        """A scan `points_m` (chair's frame) from the pose `odometry`; True: taken as a key scan.

        `heading_rad`: by the heading sensor, full turns counted. `sigma_m`: standard deviation of
        the odometry since the last key scan. `origins_m`: see KeyScan; None: all at (0, 0).
        """
        origins = np.zeros_like(points_m) if origins_m is None else origins_m
        if not self.keys:
            first = np.array((0.0, 0.0, heading_rad))
            self.keys.append(KeyScan(first, points_m, origins, heading_rad, time_s, 0.0))
            self._odometry = odometry
            return True
        before = self.keys[-1]
        moved = between(self._odometry, odometry)
        moved[2] = heading_rad - before.heading_rad
        length_m = math.hypot(moved[0], moved[1])
        if length_m < self._key_m and abs(moved[2]) < self._key_rad:
            return False
        pose, driven_m = compose(before.pose, moved), before.driven_m + length_m
        self.keys.append(KeyScan(pose, points_m, origins, heading_rad, time_s, driven_m))
        self._odometry = odometry
        number = len(self.keys) - 1
        information = np.diag(np.array((sigma_m, sigma_m, _STEP_SIGMA_RAD)) ** -2.0)
        self.edges.append(Edge(number - 1, number, moved, information))
        if number % _LOOP_EVERY == 0:
            self._close(number)
        return True

    def finish(self) -> None:
        """After the drive: search for loops again at every key scan, near its optimized pose."""
        for window_m in _FINISH_WINDOWS_M:
            steps = [edge for edge in self.edges if not edge.loop]
            loops = []
            for number in range(0, len(self.keys), _LOOP_EVERY):
                loops += self._found(number, number, window_m)
            self.edges = steps + agreeing(loops, self._poses())
            self._optimize()
            poses = self._poses()
            self.edges = [
                edge
                for edge in self.edges
                if not edge.loop or agree(edge.seen, between(poses[edge.first], poses[edge.second]))
            ]
            self._optimize()

    def known_m(self, numbers: Iterable[int]) -> FloatArray:
        """Points (N, 2), in the map, of these key scans; numbers of none are left out."""
        parts = []
        for number in numbers:
            if 0 <= number < len(self.keys):
                key = self.keys[number]
                near = np.hypot(key.points_m[:, 0], key.points_m[:, 1]) < RANGE_M
                parts.append(to_frame(key.points_m[near], key.pose))
        return np.concatenate(parts)

    def _close(self, number: int) -> None:
        """Search for loops at the newest key scan; a loop counts when a second one confirms it."""
        self._unconfirmed += self._found(number, self._tied, _WIDEST_M)
        confirmed = agreeing(self._unconfirmed, self._poses())
        self._unconfirmed = [
            edge
            for edge in self._unconfirmed
            if edge.second > number - _AROUND * 2 and not any(edge is one for one in confirmed)
        ]
        if confirmed:
            self.edges += confirmed
            self._tied = number
            self._optimize()

    def _found(self, number: int, tied: int, widest_m: float) -> list[Edge]:
        """Loops from earlier places to key scan `number`, whose drift began at key scan `tied`."""
        key, sure = self.keys[number], self.keys[tied]
        window_m = min(widest_m, _DRIFT_M + _DRIFT_PER_M * (key.driven_m - sure.driven_m))
        window_rad = _DRIFT_RAD + _DRIFT_PER_RAD * abs(key.heading_rad - sure.heading_rad)
        window_rad += _DRIFT_RAD_S * (key.time_s - sure.time_s)
        found = []
        for place in self._places(number, window_m):
            last = min(place + _AROUND, number - _LOOP_AFTER)
            known = self.known_m(range(place - _AROUND, last + 1))
            # Several scans together: one alone fits many places.
            seen = from_frame(self.known_m(range(number - _AROUND, number + 1)), key.pose)
            loop = match(known, seen, key.pose, window_m, window_rad, self.keys[place].pose)
            if loop is not None:
                found.append(Edge(place, number, *loop, loop=True))
        return found

    def _places(self, number: int, window_m: float) -> list[int]:
        """Key scans long before `number` that are near it, each of another visit."""
        last = number - _LOOP_AFTER
        if last <= 0:
            return []
        poses = np.array(self._poses()[:last])
        away_m = np.hypot(*(poses[:, :2] - self.keys[number].pose[:2]).T)
        chosen: list[int] = []
        for at in np.argsort(away_m):
            if away_m[at] > _SIGHT_M + window_m or len(chosen) == _PLACES:
                break
            if all(abs(at - other) > 4 * _AROUND for other in chosen):
                chosen.append(int(at))
        return chosen

    def _poses(self) -> list[FloatArray]:
        return [key.pose for key in self.keys]

    def _optimize(self) -> None:
        for key, pose in zip(self.keys, optimized(self._poses(), self.edges), strict=True):
            key.pose = pose
