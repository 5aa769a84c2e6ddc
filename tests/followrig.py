"""A round hall with people as discs in it, and what a lidar on a standing chair sees of them."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.following.follower import Followed, PersonFollower
from gazechair.following.legs import Scan
from gazesim import rays

SCAN_S = 0.1
LIDAR_M = 0.5
HALL_M = 6.0
_ANGLES = np.radians(np.arange(-122.0, 122.0, 0.25))

Disc = tuple[float, float, float]
Place = tuple[float, float]


def legs(place: Place, way_m: float = 0.0, heading_rad: float = 0.0) -> list[Disc]:
    """Both legs of a person at a position."""
    c, s = math.cos(heading_rad), math.sin(heading_rad)
    swing = 0.17 * math.sin(math.pi * way_m / 0.35)
    return [
        (
            place[0] + c * side * swing - s * side * 0.09,
            place[1] + s * side * swing + c * side * 0.09,
            0.055,
        )
        for side in (1.0, -1.0)
    ]


class Scene:
    """Call `look` every 0.1 s with the discs that are there."""

    def __init__(self, follower: PersonFollower | None = None) -> None:
        self.follower = follower or PersonFollower()
        self.pose = np.zeros(3)
        self.at_s = 0.0
        self._random = np.random.default_rng(1)

    def scan(self, discs: list[Disc]) -> Scan:
        """Now."""
        x, y, heading = self.pose
        origin = x + LIDAR_M * math.cos(heading), y + LIDAR_M * math.sin(heading)
        angles = _ANGLES + heading
        here = np.full(len(angles), origin[0]), np.full(len(angles), origin[1])
        metres = rays.cast_discs(*here, angles, np.array(discs, dtype=np.float64).reshape(-1, 3))
        metres = np.minimum(metres, _hall(*here, angles))
        metres += self._random.normal(0.0, 0.006, len(angles))
        points = np.stack((metres * np.cos(_ANGLES) + LIDAR_M, metres * np.sin(_ANGLES)), axis=1)
        return Scan(points, (LIDAR_M, 0.0), self.at_s)

    def look(self, discs: list[Disc]) -> Followed:
        """One scan later."""
        self.at_s += SCAN_S
        return self.follower.look(self.scan(discs), self.pose)

    def comes(self, others: list[Disc] | None = None) -> Followed:
        """Somebody comes up, stands 1.2 m before the chair, and is chosen."""
        for k in range(30):
            far = 3.35 - 0.05 * k
            followed = self.look([*legs((far, 0.0), 0.05 * k), *(others or [])])
        self.follower.choose(self.at_s)
        for _ in range(24):
            followed = self.look([*legs((1.85, 0.0)), *(others or [])])
        return followed


def _hall(x: FloatArray, y: FloatArray, angles: FloatArray) -> FloatArray:
    """Distance to the hall's wall."""
    along = x * np.cos(angles) + y * np.sin(angles)
    return np.asarray(-along + np.sqrt(along**2 - x**2 - y**2 + HALL_M**2))
