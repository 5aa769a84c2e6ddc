"""Makes a map of a home during one drive: key scans, progress, and the map at the end."""

from __future__ import annotations

import math
from datetime import datetime, timezone
from typing import Any

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between, compose, rotation
from gazechair.sensing.mapping.building.mapper import KEY_M, KEY_RAD, STEP_SIGMA_M, KeyScan, Mapper
from gazechair.sensing.mapping.building.mirrors import without_mirrored
from gazechair.sensing.mapping.building.occupancy_grid import CELL_M, box_m, occupancy_of
from gazechair.sensing.mapping.locating.looks import Looks
from gazechair.sensing.mapping.stored.home_map import MOST_CELLS, MOST_M2, HomeMap
from gazechair.sensing.odometry.doubts import TURNED

BROKEN = "broken"  # carried, or odometry started again: later scans do not fit
FULL = "making_full"  # too many key scans, or too large for a map
SILENT = "silent"  # no scans from the lidars at the moment
ASKEW = "askew"  # a lidar seems turned on its mount at the moment: so would be what it sees
_MOST_KEYS = 3000
_BORDER_M = 0.5
_NEIGHBOUR_M = 0.2


class Making:
    """Feed it looks; `doubt` is why it takes no more, "" while it does."""

    def __init__(self) -> None:
        self._mapper = Mapper()
        self._track: int | None = None
        self._turned_rad = 0.0  # map against heading sensor, so that walls lie along its axes
        self._along_m2 = 0.0
        self._odometry: FloatArray = np.zeros(3)  # at the newest key scan
        self._pose: FloatArray = np.zeros(3)
        self._low_m: FloatArray = np.full(2, math.inf)  # of what has been seen
        self._high_m: FloatArray = -self._low_m
        self.doubt = ""

    @property
    def keys(self) -> list[KeyScan]:
        """The key scans collected so far."""
        return self._mapper.keys

    def take(self, looks: Looks) -> bool:
        """Take the newest estimate and look; True: it became a key scan."""
        track, pose = looks.track, looks.pose
        if self._track is None:
            self._track = track
        if track != self._track:
            self.doubt = BROKEN
        elif len(self.keys) >= _MOST_KEYS or self._area_m2() >= MOST_M2:
            self.doubt = FULL
        else:
            self.doubt = ASKEW if TURNED in looks.newest.doubts else ""
        if self.doubt:
            return False
        moved = between(self._odometry, pose)
        if self.keys and math.hypot(moved[0], moved[1]) < KEY_M and abs(moved[2]) < KEY_RAD:
            self._pose = compose(self.keys[-1].pose, moved)
            return False
        seen = looks.seen()
        points = seen.look.points_m
        if not len(points):
            return False
        if not self.keys:
            self._turned_rad = -_slant(points, pose[2])
        along_m2 = seen.estimate.along_sigma_m**2
        sigma_m = max(STEP_SIGMA_M, math.sqrt(max(0.0, along_m2 - self._along_m2)))
        heading = pose[2] + self._turned_rad
        time_s = seen.estimate.time_s
        taken = self._mapper.add(pose, points, heading, time_s, sigma_m, seen.look.origins_m)
        if taken:
            self._along_m2, self._odometry = along_m2, pose
            self._pose = self.keys[-1].pose
            low_m, high_m = box_m(self.keys[-1:])
            self._low_m = np.minimum(self._low_m, low_m)
            self._high_m = np.maximum(self._high_m, high_m)
        return taken

    def _area_m2(self) -> float:
        return float(np.prod(self._high_m - self._low_m)) if self.keys else 0.0

    def as_json(self) -> dict[str, Any]:
        """Progress, as plain JSON values."""
        x_m, y_m, heading_rad = self._pose.tolist()
        return {
            "keys": len(self.keys),
            "loops": self._mapper.loops,
            "driven_m": round(self.keys[-1].driven_m, 1) if self.keys else 0.0,
            "doubt": self.doubt,
            "x": round(x_m, 3),
            "y": round(y_m, 3),
            "heading": round(math.degrees(heading_rad) % 360.0, 1),
        }

    def place(self, looks: Looks) -> FloatArray | None:
        """The chair's present pose in the finished map; None: it was carried."""
        if not self.keys or looks.track != self._track or self.doubt == BROKEN:
            return None
        return compose(self.keys[-1].pose, between(self._odometry, looks.pose))

    def finished(self, name: str) -> HomeMap:
        """The finished map; takes a while. ValueError: too little was seen."""
        self._mapper.finish()
        if not self.keys:
            raise ValueError("no lidar points to make a map of")
        slant = _mean_slant([_fours(key.points_m, key.pose[2]) for key in self.keys])
        upright = np.array((0.0, 0.0, -slant))
        for key in self.keys:
            key.pose = compose(upright, key.pose)
        track = np.array([key.pose for key in self.keys])
        cell_m = self._cell_m()
        grid = occupancy_of(self.keys, cell_m)
        if grid.occupied.any():
            grid = occupancy_of(without_mirrored(self.keys, grid), cell_m)
        if not grid.occupied.any():
            raise ValueError("too little was seen to make a map of")
        made = datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
        return HomeMap(name, grid, made, track)

    def _cell_m(self) -> float:
        """Size of the map's cells: larger if, closed and upright, it would have too many."""
        low_m, high_m = box_m(self.keys)
        cell_m = CELL_M
        while float(np.prod((high_m - low_m + _BORDER_M) / cell_m)) > MOST_CELLS:
            cell_m *= 2.0
        return cell_m


def _slant(points_m: FloatArray, heading_rad: float) -> float:
    """Angle of most walls from the axes, within an eighth of a turn."""
    return _mean_slant([_fours(points_m, heading_rad)])


def _fours(points_m: FloatArray, heading_rad: float) -> complex:
    """Sum of unit vectors at four times the walls' angles, so that all sides of a room agree."""
    steps = np.diff(points_m @ rotation(heading_rad).T, axis=0)
    length = np.hypot(steps[:, 0], steps[:, 1])
    near = (length > 0.0) & (length < _NEIGHBOUR_M)
    angles = np.arctan2(steps[near, 1], steps[near, 0])
    return complex((length[near] * np.exp(4j * angles)).sum())


def _mean_slant(fours: list[complex]) -> float:
    total = sum(fours)
    return float(np.angle(total)) / 4.0 if total else 0.0
