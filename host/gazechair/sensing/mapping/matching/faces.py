"""Sides from which a map's occupied cells are seen: a thin wall has two faces, a beam meets one.

A cell belongs to the face whose free floor is nearest along its row or its column.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray

SIDES = 4  # free floor towards -x, +x, -y, +y
_REACH_M = 0.078  # depth of a wall's face: range noise widens a wall seen from one side


def faces_of(occupied: BoolArray, free: BoolArray, cell_m: float) -> BoolArray:
    """(N, SIDES): to which faces each occupied cell belongs, in the order of the cells."""
    at = np.argwhere(occupied)
    reach = max(1, int(_REACH_M / cell_m))
    apart = np.stack([_apart(free, at, axis, sign, reach) for axis, sign in _STEPS], axis=1)
    nearest = np.minimum(apart[:, 0::2], apart[:, 1::2]).repeat(2, axis=1)
    return np.asarray((apart <= reach) & (apart == nearest))


def sides_of(towards: FloatArray) -> IntArray:
    """(N, 2): the two sides from which a viewer in direction `towards` (N, 2) may see a surface."""
    return np.asarray((towards > 0.0) + np.array((0, 2)))


_STEPS = ((0, -1), (0, 1), (1, -1), (1, 1))


def _apart(free: BoolArray, at: IntArray, axis: int, sign: int, reach: int) -> IntArray:
    """How many cells away the first free one is; reach + 1: none within reach."""
    padded = np.pad(free, reach)
    apart = np.full(len(at), reach + 1)
    for cells in range(reach, 0, -1):
        step = at + reach
        step[:, axis] += sign * cells
        apart[padded[step[:, 0], step[:, 1]]] = cells
    return apart
