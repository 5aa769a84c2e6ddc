"""A narrow place ahead, as a door: its middle, to a few millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray

_FAR_M = 0.7  # ahead of the front
_BESIDE_M = 0.1  # more than the chair needs
_LEAST_POINTS = 3
_NARROW_M = 0.03  # on each side: with more room no chair needs its middle
_FITS_M = -0.004
_DIRECTIONS = np.radians(np.arange(-40, 41) * 0.1)


@dataclass(frozen=True)
class Narrow:
    """Where it is."""

    ahead_m: float
    """From the front to the nearer of its sides."""
    aim_rad: float
    """The direction from the axle in which both sides have as much room."""


def narrow(points_m: FloatArray, front_m: float, needs_m: tuple[float, float]) -> Narrow | None:
    """The one that the chair may pass within 4 degrees of straight on; None: there is none.

    `front_m`: of the chair, from the axle. `needs_m`: from its middle line, left and right.
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
