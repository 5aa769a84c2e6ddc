"""Finds a narrow place ahead, such as a door, and its middle to a few millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray

_FAR_M = 0.7  # searched ahead of the front
_BESIDE_M = 0.1  # searched to each side, beyond what the chair needs
_LEAST_POINTS = 3
_NARROW_M = 0.03  # with more room on each side no chair needs the middle
_FITS_M = -0.004
_DIRECTIONS = np.radians(np.arange(-40, 41) * 0.1)


@dataclass(frozen=True)
class Narrow:
    """A narrow place that the chair fits through."""

    ahead_m: float
    """From the chair's front to the nearer of its two sides."""
    aim_rad: float
    """Direction from the axle in which both sides leave the same room."""


def narrow(points_m: FloatArray, front_m: float, needs_m: tuple[float, float]) -> Narrow | None:
    """The narrow place that the chair fits through, within 4 degrees of straight on; None: none.

    `points_m`: (N, 2). `front_m`: from the axle to the chair's front. `needs_m`: the room that the
    chair needs left and right of its middle line.
    """
    x, y = points_m[:, 0], points_m[:, 1]
    near = (x > front_m) & (x < front_m + _FAR_M) & (np.abs(y) < max(needs_m) + _BESIDE_M)
    left, right = near & (y > 0.0), near & (y <= 0.0)
    if min(np.count_nonzero(left), np.count_nonzero(right)) < _LEAST_POINTS:
        return None
    sine, cosine = np.sin(_DIRECTIONS)[:, None], np.cos(_DIRECTIONS)[:, None]
    beside = cosine * y[left] - sine * x[left], sine * x[right] - cosine * y[right]
    rooms = [side.min(axis=1) - need for side, need in zip(beside, needs_m, strict=True)]
    best = int(np.abs(rooms[0] - rooms[1]).argmin())
    if not _FITS_M <= min(rooms[0][best], rooms[1][best]) <= _NARROW_M:
        return None
    at = [
        float(x[which][side[best].argmin()])
        for which, side in zip((left, right), beside, strict=True)
    ]
    return Narrow(min(at) - front_m, float(_DIRECTIONS[best]))
