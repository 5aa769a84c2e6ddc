"""The first prototype's obstacle rule, for comparison: one flag per sector of its front lidar.

A sector that is not seen well enough counts as blocked, and so does a missing one: an area that the
lidar can't see is never free.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazelink import codes

HYSTERESIS_M = 0.05
DISTANCE_M = 0.5  # nearer than this to the lidar's centre is an obstacle
# Fraction of a sector's degrees that must have a return.
MIN_COVERAGE = 0.5

ALL_BLOCKED = (
    1 << codes.DIR_FORWARD | 1 << codes.DIR_BACKWARD | 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT
)


@dataclass(frozen=True)
class Sector:
    """A direction of motion and the arc that must be free for it.

    `direction`: codes.DIR_*. The arc runs counter-clockwise from `from_deg` to `to_deg`, both
    included, in our frame; it may pass through 180.
    """

    direction: int
    from_deg: float
    to_deg: float


# The first prototype sensed nothing behind.
SECTORS = (
    Sector(codes.DIR_FORWARD, -30.0, 30.0),
    Sector(codes.DIR_LEFT, 30.0, 90.0),
    Sector(codes.DIR_RIGHT, -90.0, -30.0),
)


@dataclass(frozen=True)
class Reading:
    """A scan's result for one sector: nearest return in metres (inf: none) and coverage 0..1."""

    nearest_m: float
    coverage: float


def measure(angles_deg: FloatArray, distances_m: FloatArray, sector: Sector) -> Reading:
    """Nearest return in the sector, and the fraction of its degrees that have one.

    Distance 0 is "no return" (nothing in 30 m, a black or mirroring surface, or a covered window):
    it neither blocks nor covers.
    """
    width_deg = (sector.to_deg - sector.from_deg) % 360.0
    offset_deg = (angles_deg - sector.from_deg) % 360.0
    inside = (offset_deg <= width_deg) & (distances_m > 0.0)
    if not inside.any():
        return Reading(float("inf"), 0.0)
    bins = max(1, int(np.ceil(width_deg)))
    seen = np.unique(np.minimum(offset_deg[inside].astype(np.int64), bins - 1))
    return Reading(float(distances_m[inside].min()), len(seen) / bins)


def blocked(angles_deg: FloatArray, distances_m: FloatArray, before: int = ALL_BLOCKED) -> int:
    """Blocked bits (1 << codes.DIR_*) for a scan of the front lidar.

    Blocked below DISTANCE_M; a direction blocked in `before` is free again only from 5 cm more. A
    direction without a sector is blocked.
    """
    bits = ALL_BLOCKED
    for sector in SECTORS:
        reading = measure(angles_deg, distances_m, sector)
        bit = 1 << sector.direction
        limit_m = DISTANCE_M + (HYSTERESIS_M if before & bit else 0.0)
        if reading.coverage >= MIN_COVERAGE and reading.nearest_m >= limit_m:
            bits &= ~bit
    return bits
