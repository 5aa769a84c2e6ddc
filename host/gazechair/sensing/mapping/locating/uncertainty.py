"""Uncertainty of a fitted pose: from the fit, the map, and its motion relative to odometry.

A wall that is misplaced in the map, or a person before a wall, biases a fit with all its points at
once. So the uncertainty is how much the pose changes when single surfaces are left out (a jackknife
over surfaces); and where the map is bent, the pose moves differently from odometry.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, IntArray
from gazechair.base.poses import between, compose, rotation
from gazechair.sensing.mapping.building.occupancy_grid import CELL_M
from gazechair.sensing.mapping.matching import ndt
from gazechair.sensing.mapping.matching.ndt import NdtGrid

# A pose is accepted below the first deviation, and given up above the second: twice these are
# 0.1 m and a little more.
FOUND_M, KEPT_M = 0.05, 0.06
# Errors of points are correlated: twice the fit's own deviation; plus the error of a map's
# surfaces, and of rounding where cells are larger than in a map that the chair made.
_SIGMAS, _MAP_M, _MAP_RAD = 2.0, 0.018, math.radians(0.3)
_ROUNDED = 12.0**-0.5  # of a cell
# Points of one wall: same orientation, and in the same strip.
_ACROSS_M, _ALONG_M = 0.5, 3.0
_LIMIT = 12.0  # squared deviations: beyond, a point counts less
_SOFT = 40.0  # information of a prior: little may be left without a surface
_FEWEST = 3
_SURFACES = 2.0  # factor: they are few, and their errors are correlated as well
# Poses against odometry: how far back, how often, and odometry's own error.
_BACK_M, _EVERY_M, _ODOMETRY = 3.0, 0.1, 0.04
_ELSEWHERE_M = 0.3  # no map is bent that much at once: the chair was carried, or the pose was wrong


def sigmas_of(
    information: FloatArray, cell_m: float, disagrees: FloatArray | None = None
) -> tuple[float, float]:
    """Standard deviations of a fitted pose: m in the worst direction, and rad.

    `information`: (3, 3), of the pose; `disagrees`: see disagreement.
    """
    covariance = np.linalg.inv(information + np.eye(3)) * _SIGMAS**2
    if disagrees is not None:
        covariance += disagrees * _SURFACES**2
    along_m2 = float(np.linalg.eigvalsh(covariance[:2, :2])[1])
    rounded_m = _ROUNDED * cell_m if cell_m > CELL_M else 0.0
    return math.hypot(_MAP_M, rounded_m, math.sqrt(along_m2)), math.sqrt(
        _MAP_RAD**2 + float(covariance[2, 2])
    )


class Unsteady:
    """Recent motion of poses relative to odometry; feed it the accepted ones."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, FloatArray, FloatArray]] = (
            deque()
        )  # driven m, place, odometry
        self._driven_m = 0.0
        self._odometry: FloatArray | None = None

    def forget(self) -> None:
        """Start again, with another odometry or map."""
        self._past.clear()
        self._odometry = None

    def judge(self, place: FloatArray, odometry: FloatArray) -> float:
        """Root of the mean square, m, beyond what odometry may be off."""
        if self._odometry is not None:
            self._driven_m += math.hypot(*(odometry - self._odometry)[:2])
        self._odometry = odometry
        while self._past and self._past[0][0] < self._driven_m - _BACK_M:
            self._past.popleft()
        if self._past:
            _, before, then = self._past[-1]
            if _apart(compose(before, between(then, odometry)), place) > _ELSEWHERE_M:
                self._past.clear()
        off = [
            max(0.0, _apart(compose(before, between(then, odometry)), place) - way)
            for way, before, then in (
                (_ODOMETRY * (self._driven_m - at_m), before, then)
                for at_m, before, then in self._past
            )
        ]
        if not self._past or self._driven_m - self._past[-1][0] >= _EVERY_M:
            self._past.append((self._driven_m, place, odometry))
        return math.sqrt(sum(one * one for one in off) / len(off)) if off else 0.0


def _apart(one: FloatArray, other: FloatArray) -> float:
    return math.hypot(one[0] - other[0], one[1] - other[1])


def disagreement(
    grid: NdtGrid,
    points_m: FloatArray,
    pose: FloatArray,
    origins_m: FloatArray,
    deviations: FloatArray | None = None,
) -> FloatArray:
    """(3, 3), covariance of x, y and heading; arguments: see ndt.fit."""
    turn = rotation(pose[2]).T
    turned = points_m @ turn
    at = turned + pose[:2]
    known, offset, weights, squared = grid.at(at, (origins_m - points_m) @ turn)
    at, turned, offset, weights = at[known], turned[known], offset[known], weights[known]
    robust = 1.0 / (1.0 + squared[known] / _LIMIT) ** 2
    wxx, wxy, wyy = (weights * robust[:, None]).T
    tx, ty = -turned[:, 1], turned[:, 0]
    gx, gy = wxx * tx + wxy * ty, wxy * tx + wyy * ty
    ox, oy = offset.T
    px, py = wxx * ox + wxy * oy, wxy * ox + wyy * oy
    of = _surfaces(at, wxx >= wyy)
    count = int(of.max(initial=-1)) + 1
    if count < _FEWEST:
        return np.zeros((3, 3))

    def summed(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(of, values, count), dtype=np.float64)

    information = np.empty((count, 3, 3))
    parts = (wxx, wxy, wyy, gx, gy, tx * gx + ty * gy)
    for (i, j), part in zip(((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)), parts, strict=True):
        information[:, i, j] = information[:, j, i] = summed(part)
    pull = np.stack((summed(px), summed(py), summed(tx * px + ty * py)), axis=1)
    held = np.full(3, _SOFT) + (0.0 if deviations is None else ndt.CORRELATED * deviations**-2.0)
    left = information.sum(axis=0) - information + np.diag(held)
    moved = np.linalg.solve(left, pull[..., None])[..., 0]
    return np.asarray((count - 1) / count * moved.T @ moved)


def _surfaces(at_m: FloatArray, across_x: BoolArray) -> IntArray:
    """(N,): which surface each point is on, counted from 0."""
    across = np.where(across_x, at_m[:, 0], at_m[:, 1])
    along = np.where(across_x, at_m[:, 1], at_m[:, 0])
    rows = np.floor(across / _ACROSS_M), np.floor(along / _ALONG_M)
    keys = (rows[0] * 4096.0 + rows[1]) * 2.0 + across_x
    return np.asarray(np.unique(keys, return_inverse=True)[1])
