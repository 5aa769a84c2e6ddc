"""What a chair's front lidar sees of a room, without its device: points in the chair's frame."""

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
) -> np.ndarray:
    """One turn of the lidar; the chair stands at (x_m, 0)."""
    heading = math.radians(heading_deg)
    x, y = x_m + ORIGIN[0] * math.cos(heading), ORIGIN[0] * math.sin(heading)
    ranges = room.cast(x, y, _ROUND + heading, _HEIGHT_M)
    ranges = ranges + chance.normal(0.0, noise_m, len(ranges))
    rays = np.column_stack((np.cos(_ROUND), np.sin(_ROUND))) * ranges[:, None]
    return rays[np.isfinite(ranges)] + ORIGIN


def view_of(points: np.ndarray, at_s: float) -> ChairView:
    """Those points as the lidar service publishes them, with nothing masked."""
    return ChairView(points, _OPEN, ORIGIN, at_s, codes.SIMULATED)
