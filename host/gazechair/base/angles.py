"""Wraps angles into one turn: a remainder several times faster than numpy's."""

from __future__ import annotations

import numpy as np

from gazechair.base.footprint import FloatArray


def in_turn(angles: FloatArray, turn: float) -> FloatArray:
    """`angles % turn`, bit for bit; fast when most are within a turn of 0."""
    found = wrapped(angles, turn)
    far = np.abs(angles) >= turn
    if np.count_nonzero(far):
        found[far] = angles[far] % turn
    return found


def wrapped(angles: FloatArray, turn: float) -> FloatArray:
    """The same in half the time, if all angles are within [-turn, turn)."""
    found: FloatArray = angles + (angles < 0.0) * turn  # so the remainder of -0.0 is 0.0, too
    return found
