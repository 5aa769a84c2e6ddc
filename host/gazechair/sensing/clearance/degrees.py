"""The directions about a lidar in which views are compared: as many bins as a view has."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.angles import in_turn_if_near
from gazechair.base.arrays import FloatArray, IntArray
from gazechair.sensing.lidar.blind import BINS

BIN_RAD = 2.0 * math.pi / BINS


def bins_of(bearings_rad: FloatArray) -> IntArray:
    """The bin of each bearing, -2 pi <= bearing < 2 pi. Bin 0 begins ahead, to the left."""
    turn = in_turn_if_near(bearings_rad, 2.0 * math.pi)
    return np.minimum((turn / BIN_RAD).astype(np.int64), BINS - 1)
