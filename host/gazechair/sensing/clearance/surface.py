"""Filters range noise: averages beams on the same surface, and leaves an isolated beam unchanged.

A sigma filter over the neighbouring beams: each range becomes the mean of those near it that differ
by less than five times the noise (3 to 15 cm). The noise is measured in each scan, so a quiet lidar
keeps its edges and a noisy one does not find obstacles in every surface. A single beam that stands
out by more than that has no such neighbour, and is neither moved nor dropped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray

_NEIGHBOURS = 12  # beams to each side
_WINDOW_RAD = 0.03  # and no farther than this
_SMOOTH_M = 2.0  # farther points neither stop nor slow the chair
_NEXT_RAD = 0.01  # beams this close to each other are neighbours
_GATE_SIGMA = 5.0
_LEAST_GATE_M = 0.03
_MOST_GATE_M = 0.15  # noise of 3 cm
_ALIKE_M = 0.15  # a neighbour within this makes an obstacle of two beams
_ROUND = np.array(((2.0 * math.pi,), (0.0,)))  # a bearing a turn later, at the same range
_BEYOND = np.full(_NEIGHBOURS, 1e6)  # padding at both ends, unlike any range


@dataclass(frozen=True)
class Surfaces:
    """The points of one lidar, smoothed, in the order of their bearings."""

    points_m: FloatArray
    """(N, 2)."""
    ranges_m: FloatArray
    """(N,): how far they are from the lidar."""
    bearings_rad: FloatArray
    """(N,): ascending, about the lidar."""
    turns_rad: FloatArray
    """(N,): from each to the next, round the circle."""
    lone: BoolArray
    """(N,): True if no neighbouring beam measured about the same."""
    noise_m: float
    """Range noise of a beam before smoothing, standard deviation."""


def noise_m(ranges_m: FloatArray) -> float:
    """The range noise (standard deviation) of neighbouring beams; steps and slopes count little.

    From the median of the second differences, whose standard deviation is sqrt(6) times the noise.
    """
    if len(ranges_m) < 8:
        return 0.0
    bend = np.abs(ranges_m[2:] - 2.0 * ranges_m[1:-1] + ranges_m[:-2])
    middle = len(bend) // 2
    bend.partition(middle)
    median = float(bend[middle])
    if len(bend) % 2 == 0:
        median = (float(bend[:middle].max()) + median) / 2.0
    return 1.4826 * median / math.sqrt(6.0)


def surfaces(
    points_m: FloatArray, origin_m: tuple[float, float], polar: FloatArray | None = None
) -> Surfaces:
    """Smooth the (N, 2) returns of one lidar that sits at `origin_m`.

    `polar`: their bearings (radians) and ranges about it, (2, N), if they are known.
    """
    # Two rows, x and y: numpy is slow with many rows of two.
    origin = np.array(origin_m)[:, None]
    offset = points_m.T - origin
    if polar is None:
        polar = np.array((np.arctan2(offset[1], offset[0]), np.hypot(offset[0], offset[1])))
    order = np.argsort(polar[0], kind="stable")
    polar, offset = polar.take(order, axis=1), offset.take(order, axis=1)
    bearings, ranges = polar
    noise = noise_m(ranges)
    smooth = _smoothed(bearings, ranges, noise)
    apart = np.empty_like(polar)
    np.subtract(polar[:, 1:], polar[:, :-1], out=apart[:, :-1])
    apart[:, -1:] = polar[:, :1] + _ROUND - polar[:, -1:]
    turns, steps = apart
    alike = (np.abs(steps) < _ALIKE_M) & (turns < _NEXT_RAD) & (turns > 0.0)
    lone = ~(alike | np.concatenate((alike[-1:], alike[:-1])))
    # In place: at this size, fresh memory takes longer than the computation.
    stretch = np.maximum(ranges, 1e-9)
    np.divide(smooth, stretch, out=stretch)
    offset *= stretch
    offset += origin
    return Surfaces(offset.T, smooth, bearings, turns, lone, noise)


def _smoothed(bearings: FloatArray, ranges: FloatArray, noise: float) -> FloatArray:
    gate_m = min(max(_GATE_SIGMA * noise, _LEAST_GATE_M), _MOST_GATE_M)
    near = (ranges < _SMOOTH_M).nonzero()[0]
    if not len(near):
        return ranges
    # A row for each neighbour, the beam itself in the middle; padded at the ends.
    centres, towards = ranges.take(near), bearings.take(near)
    around = _windows(centres)
    apart = _windows(towards) - towards
    close = np.abs(apart, out=apart) < _WINDOW_RAD
    for _ in range(2):  # the second time, the centre itself is no outlier
        np.subtract(around, centres, out=apart)
        taken = np.abs(apart, out=apart) < gate_m
        taken &= close
        count = np.add.reduce(taken.view(np.uint8), axis=0, dtype=np.uint8)
        total = np.add.reduce(np.multiply(around, taken, out=apart), axis=0)
        np.divide(total, count, out=centres, where=count > 0)
    smooth = ranges.copy()
    smooth[near] = centres
    return smooth


def _windows(values: FloatArray) -> FloatArray:
    padded = np.concatenate((_BEYOND, values, _BEYOND))
    rows = 2 * _NEIGHBOURS + 1
    step = padded.strides[0]
    return np.ndarray((rows, len(values)), np.float64, padded, strides=(step, step))
