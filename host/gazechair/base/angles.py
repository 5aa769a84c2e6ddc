"""Brings angles into one turn: the remainder, several times faster than numpy's."""

from __future__ import annotations

import numpy as np

from gazechair.base.footprint import FloatArray


def in_turn(angles: FloatArray, turn: float) -> FloatArray:
    """`angles % turn`, equal to the last bit; fast where most are within a turn of 0."""
    found: FloatArray = angles + (angles < 0.0) * turn  # so the remainder of -0.0 is 0.0, too
    far = np.abs(angles) >= turn
    if far.any():
        found[far] = angles[far] % turn
    return found
