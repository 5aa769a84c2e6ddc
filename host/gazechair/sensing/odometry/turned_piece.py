"""Tests whether an unmatched piece would match known surfaces if it were rotated by some degrees.

If so, the lidar has turned and the heading sensor has not: it was bumped by more than a fit can
follow, or its scans are older than their times say while the chair turns.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.odometry.local_map import LocalMap
from gazechair.sensing.odometry.match import lie_on

_DEG = np.array([sign * deg for deg in np.arange(3.0, 16.0, 1.5) for sign in (-1.0, 1.0)])
_POINTS = 90
_LIES = 0.8  # share of the points: with so many matched there is nothing to test
_WOULD_LIE, _MORE = 0.7, 0.25  # shares: matched when rotated, and gained by the rotation
_FOUND, _OF = 2, 3  # pieces: the two halves of a turn see different surfaces


class TurnedPiece:
    """Feed it every piece with its expected pose."""

    def __init__(self) -> None:
        self._found: deque[bool] = deque(maxlen=_OF)

    def judge(
        self,
        surfaces: LocalMap,
        points: FloatArray,
        normals: FloatArray,
        lidar: tuple[float, float],
        expected: tuple[float, float, float],
        matched: float,
    ) -> bool:
        """Whether it would; points, normals and the lidar's position are in the chair's frame.

        `expected`: the chair's x, y and heading; `matched`: share of the points that lie on
        surfaces by the fit.
        """
        if matched >= _LIES or not len(points):
            self._found.append(False)
            return False
        every = max(1, len(points) // _POINTS)
        points, normals, about = points[::every], normals[::every], np.array(lidar)
        turn, turns = _rotations(np.array((expected[2],)))[0], _rotations(np.radians(_DEG))
        placed = ((points - about) @ turns + about) @ turn + expected[:2]
        turned = normals @ turns @ turn
        lie = lie_on(surfaces, placed.reshape(-1, 2), turned.reshape(-1, 2))
        best = float(lie.reshape(len(turns), -1).mean(axis=1).max())
        self._found.append(best >= max(_WOULD_LIE, matched + _MORE))
        return self._found[-1] and sum(self._found) >= _FOUND


def _rotations(angles_rad: FloatArray) -> FloatArray:
    """(N, 2, 2), to multiply rows with."""
    c, s = np.cos(angles_rad), np.sin(angles_rad)
    return np.asarray(np.stack((np.stack((c, s), -1), np.stack((-s, c), -1)), axis=1))
