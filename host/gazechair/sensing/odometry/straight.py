"""Gives surfaces along the main wall one direction, so that the wall tells nothing along itself.

A cell's direction, from few noisy points, is some degrees off. Hundreds of such surfaces would seem
to determine the position along a bare corridor, always where it was expected.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.footprint import FloatArray

_BINS = 90  # of half a turn
_MAIN_RAD = math.radians(4.0)  # around the fullest bins: they give the direction


def straightened(angles_rad: FloatArray, most_rad: FloatArray, lengths: FloatArray) -> FloatArray:
    """The directions, those that may be the main one replaced by it.

    `most_rad`: by how much each may be off; `lengths`: how much each counts.
    """
    if not len(angles_rad):
        return angles_rad
    share = angles_rad / math.pi % 1.0
    bins = np.minimum((share * _BINS).astype(np.int64), _BINS - 1)
    counts = np.bincount(bins, lengths, _BINS)
    fullest = int(np.argmax(counts + np.roll(counts, -1)))  # the pair of bins that begins there
    away = angles_rad - math.pi * (fullest + 1.0) / _BINS
    off = 0.5 * half_turn_rad(2.0 * away)  # a surface looks the same from behind
    near = np.abs(off) < _MAIN_RAD
    mean_rad = float((off[near] * lengths[near]).sum() / lengths[near].sum())
    off -= mean_rad
    return np.where(np.abs(off) < most_rad, angles_rad - off, angles_rad)
