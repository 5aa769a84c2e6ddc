"""Distinguishes a piece of wall from a person.

Through an opening a lidar may see a piece of the wall behind that is as wide as a person. It is no
person if another lidar sees a flat surface there that continues on both sides. A person who leans
against that wall stands out from it.

Along a wall or an open door the ranges of neighbouring beams differ as much as those of different
objects, and between two such steps a piece may be as wide as a person. It is no person if it is
flat and the beams beside it, nearer on one side and farther on the other, are in line with it.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray

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
    own, own_off = _lined(piece_m, middle, piece_m)
    there, off = _lined(piece_m, middle, near)
    if max(off.max(), own_off.max()) > _FLAT_M:
        return False
    ends = there.min() < own.min() - _BEYOND_M and there.max() > own.max() + _BEYOND_M
    return bool(ends and np.diff(np.sort(there)).max() < 2.0 * _BEYOND_M)


def askew(piece_m: FloatArray, before_m: FloatArray, after_m: FloatArray) -> bool:
    """True if `piece_m` (N, 2), in the order of the beams, is part of a surface seen askew.

    `before_m`, `after_m`: the returns (2,) of the beams next to it.
    """
    middle = piece_m.mean(axis=0)
    own, own_off = _lined(piece_m, middle, piece_m)
    there, off = _lined(piece_m, middle, np.stack((before_m, after_m)))
    if max(off.max(), own_off.max()) > _FLAT_M:
        return False
    gaps = (own[0] - there[0], there[1] - own[-1])
    if own[0] > own[-1]:
        gaps = (-gaps[0], -gaps[1])
    return bool(min(gaps) > 0.0 and max(gaps) < 2.0 * _BEYOND_M)


def _lined(
    piece_m: FloatArray, middle: FloatArray, points_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Of points, the distances along the piece's longest extent, from its middle, and off it."""
    x, y = (piece_m - middle).T
    direction = 0.5 * math.atan2(2.0 * (x @ y), x @ x - y @ y)
    along = np.array((math.cos(direction), math.sin(direction)))
    off = points_m - middle
    return off @ along, np.abs(off @ (-along[1], along[0]))
