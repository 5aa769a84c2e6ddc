"""The stored map of a simulated room, made from scans of its two lidars at many places."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import occupancy_of
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.places import Drawn
from gazesim.lidar_noise import NOISE_M
from gazesim.rooms import Room
from gazesim.world import LIDAR_HEIGHT_M, TWO

_EVERY_M = 0.7
_HEADINGS_DEG = (0.0, 90.0, 180.0, 270.0)
_BEAMS = 1080
_SEEN_DEG = 135.0


def store(room: Room, places: Mapping[str, tuple[str, float, float, float]], path: Path) -> None:
    """Save the map to `path`; `places`: sign, x, y, heading in degrees, by name."""
    rows = room.body_segments().reshape(-1, 2)
    low, high = rows.min(axis=0), rows.max(axis=0)
    chance = np.random.default_rng(1)
    keys = [
        _key_scan(room, np.array((x, y, math.radians(heading))), chance)
        for x in np.arange(low[0], high[0], _EVERY_M)
        for y in np.arange(low[1], high[1], _EVERY_M)
        for heading in _HEADINGS_DEG
        if room.clearance_m(x, y, heading) > 0.02
    ]
    drawn = Drawn()
    for name, (icon, x, y, heading) in places.items():
        drawn = drawn.with_place({"name": name, "icon": icon, "x": x, "y": y, "heading": heading})
    path.parent.mkdir(parents=True, exist_ok=True)
    HomeMap("Thuis", occupancy_of(keys), drawn=drawn).save(path)


def _key_scan(room: Room, pose: FloatArray, chance: np.random.Generator) -> KeyScan:
    points, origins = [], []
    c, s = math.cos(pose[2]), math.sin(pose[2])
    for x, y, heading_deg in TWO:
        # Each corner lidar sees 270 degrees: not the quarter that the chair fills.
        own = np.linspace(45.0 - _SEEN_DEG, 45.0 + _SEEN_DEG, _BEAMS)
        angles = np.radians(own + heading_deg)
        at = pose[0] + c * x - s * y, pose[1] + s * x + c * y
        metres = room.cast(*at, angles + pose[2], LIDAR_HEIGHT_M)
        seen = np.isfinite(metres)
        noisy = metres[seen] + chance.normal(0.0, NOISE_M, int(seen.sum()))
        rays = np.stack((np.cos(angles[seen]), np.sin(angles[seen])), axis=1)
        points.append(np.array((x, y)) + noisy[:, None] * rays)
        origins.append(np.tile((x, y), (len(noisy), 1)))
    return KeyScan(pose, np.concatenate(points), np.concatenate(origins), 0.0, 0.0, 0.0)
