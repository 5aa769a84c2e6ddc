"""Gives surfaces along the main wall one direction, so that the wall tells nothing along itself.

A cell's direction, from few noisy points, is some degrees off. Hundreds of such surfaces would seem
to determine the position along a bare corridor, always where it was expected.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.angles import half_turn_rad
from gazechair.base.arrays import BoolArray, FloatArray

_BINS = 90  # of half a turn
_MAIN_RAD = math.radians(4.0)  # around the fullest bins: they give the direction
_FACES_RAD = math.radians(60.0)  # farther off it, a surface faces along the main wall


def main_direction(angles_rad: FloatArray, lengths: FloatArray) -> float:
    """The direction of most surfaces, radians; `lengths`: how much each counts."""
    if not len(angles_rad):
        return 0.0
    share = angles_rad / math.pi % 1.0
    bins = np.minimum((share * _BINS).astype(np.int64), _BINS - 1)
    counts = np.bincount(bins, lengths, _BINS)
    fullest = int(np.argmax(counts + np.roll(counts, -1)))  # the pair of bins that begins there
    main_rad = math.pi * (fullest + 1.0) / _BINS
    off = _off(angles_rad, main_rad)
    near = np.abs(off) < _MAIN_RAD
    return main_rad + float((off[near] * lengths[near]).sum() / lengths[near].sum())


def straightened(angles_rad: FloatArray, most_rad: FloatArray, main_rad: float) -> FloatArray:
    """The directions, those that may be the main one replaced by it.

    `most_rad`: by how much each may be off.
    """
    off = _off(angles_rad, main_rad)
    return np.where(np.abs(off) < most_rad, angles_rad - off, angles_rad)


def as_seen(
    angles_rad: FloatArray, seen_rad: FloatArray, by_several: BoolArray, main_rad: float
) -> FloatArray:
    """The directions, none farther off the main one than what is seen there.

    A surface remembered across a corner is slanted. To it a wall that passes the corner looks the
    same wherever it is: the chair would seem to stand. So does a far wall to what was remembered of
    one beam, which hits it always as far ahead. `seen_rad`: NaN: not known; the direction is then
    kept if it faces along the main wall; `by_several`: where more than one beam shows it.
    """
    off = _off(angles_rad, main_rad)
    unknown = np.where(by_several & (np.abs(off) > _FACES_RAD), off, 0.0)
    seen = np.where(np.isnan(seen_rad), unknown, _off(seen_rad, main_rad))
    # The main direction itself, where that is between the two.
    beside = (seen * off > 0.0) | (np.abs(seen) + np.abs(off) > 0.5 * math.pi)
    least = np.where(beside, np.copysign(np.minimum(np.abs(seen), np.abs(off)), off), 0.0)
    return np.asarray(angles_rad + (least - off))


def _off(angles_rad: FloatArray, main_rad: float) -> FloatArray:
    """By how much directions are off the main one; a surface looks the same from behind."""
    return 0.5 * half_turn_rad(2.0 * (angles_rad - main_rad))
