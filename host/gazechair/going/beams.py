"""Finds places that lidar beams pass through: what stood there earlier has gone.

A place counts as free only where every beam that passes near it ends well beyond it: thin legs and
edges stay, and pose errors clear nothing that is still there.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray

_BESIDE_M = 0.08
"""Only beams that pass within this distance of a place decide whether it is free."""
_BEYOND_M = 0.15
"""All of these beams must end at least this far behind the place."""
_LEAST_BEAMS = 3
_ONE_LIDAR_M = 0.1
_TURN = 2.0 * np.pi


def looked_through(places_m: FloatArray, points_m: FloatArray, origins_m: FloatArray) -> BoolArray:
    """(N,): whether the beams of one lidar pass through each of `places_m` (N, 2).

    `points_m`, `origins_m`: where the beams end and begin, both (M, 2).
    """
    found = np.zeros(len(places_m), dtype=np.bool_)
    if len(places_m):
        for beams in of_each_lidar(origins_m):
            found |= _through(places_m, points_m[beams], origins_m[beams[0]])
    return found


def of_each_lidar(origins_m: FloatArray) -> list[IntArray]:
    """Indices of each lidar's beams, by their origins; a rotation may arrive in several pieces."""
    found: list[tuple[FloatArray, list[IntArray]]] = []
    cuts = np.flatnonzero((np.diff(origins_m, axis=0) != 0.0).any(axis=1)) + 1
    for piece in np.split(np.arange(len(origins_m)), cuts):
        if not len(piece):
            continue
        at = origins_m[piece[0]]
        same = [beams for first, beams in found if np.hypot(*(first - at)) < _ONE_LIDAR_M]
        if same:
            same[0].append(piece)
        else:
            found.append((at, [piece]))
    return [np.concatenate(beams) for _, beams in found]


def _through(places_m: FloatArray, points_m: FloatArray, origin_m: FloatArray) -> BoolArray:
    """As `looked_through`, for the beams of one lidar."""
    bearings, ranges = _polar(points_m - origin_m)
    order = np.argsort(bearings)
    bearings, ranges = bearings[order], ranges[order]
    bearings = np.concatenate((bearings - _TURN, bearings, bearings + _TURN))
    ranges = np.concatenate((ranges, ranges, ranges, (0.0,)))  # closes the last window
    at, far_m = _polar(places_m - origin_m)
    half = np.arcsin(np.minimum(_BESIDE_M / np.maximum(far_m, _BESIDE_M), 1.0))
    first = np.searchsorted(bearings, at - half)
    end = np.searchsorted(bearings, at + half)
    windows = np.stack((first, np.maximum(end, first + 1)), axis=1).reshape(-1)
    nearest = np.minimum.reduceat(ranges, np.minimum(windows, len(ranges) - 1))[::2]
    return np.asarray((end - first >= _LEAST_BEAMS) & (nearest > far_m + _BEYOND_M))


def _polar(off_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.arctan2(off_m[:, 1], off_m[:, 0]), np.hypot(off_m[:, 0], off_m[:, 1])
