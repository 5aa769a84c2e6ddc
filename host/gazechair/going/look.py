"""Go where I look: a spot of the floor becomes a goal for the mission, with a map or without one.

Without one, a map is made of what the lidars see from here, in odometry's frame. As in any map, a
place that no beam has passed is no goal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.footprint import Footprint
from gazechair.going.costmap import Costmap
from gazechair.going.outline import own_place
from gazechair.going.plan import GOAL_BLOCKED, NoPath, Pose
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of

NEAREST_M = 0.3
"""A spot nearer to the drive axle is refused."""
CLEAR_M = 0.03
"""Least clearance of the footprint at the goal, by the costmap."""
# Reasons, keys of the string tables.
TOO_NEAR, UNSEEN = "look_too_near", "look_unseen"
_HEADINGS_RAD = np.radians(np.arange(0.0, 181.0, 10.0))
_LEAST_SCANS = 2  # an occupancy grid relies on no fewer


def seen_from_here(scans: Sequence[KeyScan], footprint: Footprint) -> OccupancyGrid:
    """Map of a few scans, taken at standstill. ValueError: fewer than two, or all are empty.

    The floor under the chair counts as free: it stands there.
    """
    if len(scans) < _LEAST_SCANS:
        raise ValueError(f"{len(scans)} scans: at least {_LEAST_SCANS} are needed")
    grid = occupancy_of(scans)
    cells = np.argwhere(grid.passes == 0)
    x, y, heading = scans[-1].pose
    off = (cells + 0.5) * grid.cell_m + grid.low_m - (x, y)
    c, s = math.cos(heading), math.sin(heading)
    under = cells[own_place(footprint).contains(off @ np.array(((c, -s), (s, c))))]
    passes = grid.passes.copy()
    passes[under[:, 0], under[:, 1]] = len(scans)
    return replace(grid, passes=passes)


def goal(
    spot_m: tuple[float, float], pose: Pose, grid: OccupancyGrid, costmap: Costmap
) -> Pose | NoPath:
    """Where to stop for a spot in the chair's frame: on it, facing away from the chair if it fits.

    `pose`: the chair's when the picture was taken, in the frame of `grid` and `costmap`.
    """
    if math.hypot(*spot_m) < NEAREST_M:
        return NoPath(TOO_NEAR)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    x = pose[0] + c * spot_m[0] - s * spot_m[1]
    y = pose[1] + s * spot_m[0] + c * spot_m[1]
    if not _is_seen(grid, np.array((x, y))):
        return NoPath(UNSEEN)
    along = math.atan2(y - pose[1], x - pose[0])
    headings = along + np.concatenate((_HEADINGS_RAD, -_HEADINGS_RAD[1:]))
    clear = costmap.clearance_m(np.full(len(headings), x), np.full(len(headings), y), headings)
    fits = np.flatnonzero(clear >= CLEAR_M)
    if not len(fits):
        return NoPath(GOAL_BLOCKED)
    best = headings[fits[np.abs(headings[fits] - along).argmin()]]
    return x, y, math.remainder(float(best), 2.0 * math.pi)


def _is_seen(grid: OccupancyGrid, place_m: FloatArray) -> bool:
    i, j = np.floor((place_m - grid.low_m) / grid.cell_m).astype(np.int64)
    nx, ny = grid.passes.shape
    if not (0 <= i < nx and 0 <= j < ny):
        return False
    # Far off, a cell between two beams may have none of its own.
    near = grid.passes[max(0, i - 2) : i + 3, max(0, j - 2) : j + 3]
    return bool(near.any())
