"""Notices pictures that do not show the floor ahead, because the camera hangs.

Compares a picture, and where it shows the line, with earlier ones that were taken elsewhere.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.polyline import evenly
from gazechair.base.poses import between
from gazechair.following.line_view import Picture

_STILL_M, _STILL_RAD = 0.04, math.radians(2.0)
_SAME_SHARE = 0.9
"""Of the pixels: a clock, or a cursor, changes in a picture that hangs."""
_APART_M, _APART_RAD = 0.12, math.radians(6.0)  # between two that are kept
_KEPT = 7
_SINCE_M, _SINCE_RAD = 0.24, math.radians(11.0)  # nearer ones show nothing new
_COMPARED, _LEAST = 10, 4  # points of the new line, from the nearest on
_OFF_M = 0.08
_STEP_M = 0.04


class FrozenPicture:
    """Detects a picture that does not change although the chair moves."""

    def __init__(self) -> None:
        self._picture: Picture | None = None
        self._pose: FloatArray = np.zeros(3)

    def hangs(self, picture: Picture, pose: FloatArray) -> bool:
        """Take in a picture; True if the camera hangs."""
        if self._picture is None or (picture == self._picture).mean() < _SAME_SHARE:
            self._picture, self._pose = picture.copy(), pose
        return _moved(pose, self._pose, _STILL_M, _STILL_RAD)


class LineMemory:
    """Where earlier pictures showed the line, in the frame of the poses."""

    def __init__(self) -> None:
        self._kept: deque[tuple[FloatArray, FloatArray]] = deque(maxlen=_KEPT)  # pose, line

    def keep(self, line_m: FloatArray, pose: FloatArray) -> None:
        """Remember the points (N, 2) that a picture has shown."""
        if not self._kept or _moved(pose, self._kept[-1][0], _APART_M, _APART_RAD):
            self._kept.append((pose, evenly(line_m, _STEP_M)))

    def contradicts(self, line_m: FloatArray, pose: FloatArray) -> bool:
        """True if most of what earlier pictures showed there lies elsewhere.

        One alone may have mistaken a crossing line far ahead for this one.
        """
        near = line_m[:_COMPARED]
        off = [
            _off_m(near, line) for at, line in self._kept if _moved(pose, at, _SINCE_M, _SINCE_RAD)
        ]
        known = [one for one in off if one is not None]
        return len(known) > 1 and 2 * sum(one > _OFF_M for one in known) > len(known)


def _off_m(points_m: FloatArray, line_m: FloatArray) -> float | None:
    """How far the points lie beside the line; None: too few lie beside it."""
    gaps = np.hypot(*(points_m[:, None] - line_m).transpose(2, 0, 1))
    nearest = gaps.argmin(axis=1)
    beside = (nearest > 0) & (nearest < len(line_m) - 1)
    return float(np.median(gaps.min(axis=1)[beside])) if beside.sum() >= _LEAST else None


def _moved(pose: FloatArray, since: FloatArray, by_m: float, by_rad: float) -> bool:
    moved = between(since, pose)
    return math.hypot(moved[0], moved[1]) > by_m or abs(moved[2]) > by_rad
