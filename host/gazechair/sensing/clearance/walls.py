"""Distinguishes a piece of wall from a person: one lidar sees it in a door, another sees it go on.

Through an opening a lidar may see a piece of the wall behind that is as wide as a person. It is no
person if another lidar sees a flat surface there that continues on both sides. A person who leans
against that wall stands out from it.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.footprint import FloatArray

_AROUND_M = 0.7  # examined of the wall, on both sides of the piece's middle
_FLAT_M = 0.03
_BEYOND_M = 0.1
_LEAST_POINTS = 8


def goes_on(piece_m: FloatArray, others_m: FloatArray) -> bool:
    """True if `piece_m` (N, 2) is part of a wall in `others_m` (M, 2), another lidar's returns."""
    middle = piece_m.mean(axis=0)
    apart_m = np.hypot(others_m[:, 0] - middle[0], others_m[:, 1] - middle[1])
    near = others_m[(apart_m < _AROUND_M).nonzero()[0]]
    if len(near) < _LEAST_POINTS:
        return False
    x, y = (piece_m - middle).T
    direction = 0.5 * math.atan2(2.0 * (x @ y), x @ x - y @ y)  # of the longest extent
    along = np.array((math.cos(direction), math.sin(direction)))
    off = np.abs((near - middle) @ (-along[1], along[0]))
    if off.max() > _FLAT_M or np.abs((piece_m - middle) @ (-along[1], along[0])).max() > _FLAT_M:
        return False
    own, there = (piece_m - middle) @ along, (near - middle) @ along
    ends = there.min() < own.min() - _BEYOND_M and there.max() > own.max() + _BEYOND_M
    return bool(ends and np.diff(np.sort(there)).max() < 2.0 * _BEYOND_M)
