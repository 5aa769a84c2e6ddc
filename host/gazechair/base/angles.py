"""Angles brought into one turn: from 0 to a turn, or from half a turn back to half a turn on."""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np

from gazechair.base.arrays import FloatArray

Angle = TypeVar("Angle", float, FloatArray)


def half_turn_deg(angle_deg: Angle) -> Angle:
    """The same direction in [-180, 180)."""
    return (angle_deg + 180.0) % 360.0 - 180.0


def half_turn_rad(angle_rad: Angle) -> Angle:
    """The same direction in [-pi, pi)."""
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi


def in_turn(angles: FloatArray, turn: float) -> FloatArray:
    """`angles % turn`, bit for bit; several times faster when most are within a turn of 0."""
    found = in_turn_if_near(angles, turn)
    far = np.abs(angles) >= turn
    if np.count_nonzero(far):
        found[far] = angles[far] % turn
    return found


def in_turn_if_near(angles: FloatArray, turn: float) -> FloatArray:
    """The same in half the time, if all angles are within [-turn, turn)."""
    found: FloatArray = angles + (angles < 0.0) * turn  # so the remainder of -0.0 is 0.0, too
    return found
