"""What a chair's lidar sees of a room, without its device: points in the chair's frame."""

from __future__ import annotations

import math

import numpy as np

from gazechair.sensing.lidar.blind import SEEN
from gazechair.sensing.lidar.scan import ChairView
from gazelink import codes
from gazesim.rooms import Room

ORIGIN = (0.5, 0.0)
LOOK_S = 0.05
HALL = ((-3, -3, 6, -3), (6, -3, 6, 3), (6, 3, -3, 3), (-3, 3, -3, -3))
NOISE_M = 0.006
_ROUND = np.radians(np.arange(0.0, 360.0, 0.225))
_HEIGHT_M = 0.25
_OPEN = np.full(360, SEEN, dtype=np.uint8)


def points_of(
    room: Room,
    chance: np.random.Generator,
    noise_m: float = NOISE_M,
    x_m: float = 0.0,
    heading_deg: float = 0.0,
    origin_m: tuple[float, float] = ORIGIN,
) -> np.ndarray:
    """One turn of the lidar that sits at `origin_m`; the chair stands at (x_m, 0)."""
    heading = math.radians(heading_deg)
    c, s = math.cos(heading), math.sin(heading)
    x, y = x_m + origin_m[0] * c - origin_m[1] * s, origin_m[0] * s + origin_m[1] * c
    ranges = room.cast(x, y, _ROUND + heading, _HEIGHT_M)
    ranges = ranges + chance.normal(0.0, noise_m, len(ranges))
    rays = np.column_stack((np.cos(_ROUND), np.sin(_ROUND))) * ranges[:, None]
    return rays[np.isfinite(ranges)] + origin_m


def view_of(points: np.ndarray, at_s: float, origin_m: tuple[float, float] = ORIGIN) -> ChairView:
    """Those points as the lidar service publishes them, with nothing masked."""
    return ChairView(points, _OPEN, origin_m, at_s, codes.SIMULATED)
