"""How uncertain a fitted place is: by the fit, by the map, and by how it moved against odometry.

A wall that is drawn where it is not, and a person before a wall, pull a fit one way, all points of
them together. So the pose is as uncertain as it changes when one surface or another is left out (a
jackknife over surfaces); and where the map is bent, the place moves otherwise than odometry.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from gazechair.base.footprint import BoolArray, FloatArray
from gazechair.sensing.mapping import ndt
from gazechair.sensing.mapping.ndt import NdtGrid
from gazechair.sensing.mapping.occupancy_grid import CELL_M
from gazechair.sensing.mapping.poses import between, compose, rotation

# A place is found with less than this deviation, and given up with more than that: twice of it
# are 0.1 m and a little.
FOUND_M, KEPT_M = 0.05, 0.06
# Points err together, by what a fit claims twice; and a map's surfaces are right within this, and
# within what is lost where cells are larger than in a map of the chair's own.
_SIGMAS, _MAP_M, _MAP_RAD = 2.0, 0.018, math.radians(0.3)
_ROUNDED = 12.0**-0.5  # of a cell
# Points of one wall: their surface looks the same way, and lies in the same strip.
_ACROSS_M, _ALONG_M = 0.5, 3.0
_LIMIT = 12.0  # squared deviations: beyond, a point counts less
_SOFT = 40.0  # information: what is left when a surface is taken away may be little
_FEWEST = 3
_SURFACES = 2.0  # they are few, and err together as well
# Places against odometry: so far back, one each so often, and what odometry may be off.
_BACK_M, _EVERY_M, _ODOMETRY = 3.0, 0.1, 0.04
_ELSEWHERE_M = 0.3  # no map is bent that much at once: it was carried, or the place was another


def sigmas_of(
    fitted: ndt.Fit, cell_m: float, disagrees: FloatArray | None = None
) -> tuple[float, float]:
    """Standard deviations of a fitted place, m in the direction known worst, and of its heading.

    `disagrees`: see disagreement.
    """
    covariance = np.linalg.inv(fitted.information + np.eye(3)) * _SIGMAS**2
    if disagrees is not None:
        covariance += disagrees * _SURFACES**2
    along_m2 = float(np.linalg.eigvalsh(covariance[:2, :2])[1])
    rounded_m = _ROUNDED * cell_m if cell_m > CELL_M else 0.0
    return math.hypot(_MAP_M, rounded_m, math.sqrt(along_m2)), math.sqrt(
        _MAP_RAD**2 + float(covariance[2, 2])
    )


class Unsteady:
    """How much places have moved against odometry lately; feed it those that count."""

    def __init__(self) -> None:
        self._past: deque[tuple[float, FloatArray, FloatArray]] = (
            deque()
        )  # driven m, place, odometry
        self._driven_m = 0.0
        self._odometry: FloatArray | None = None

    def forget(self) -> None:
        """Odometry, or the map, is another."""
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


def _surfaces(at_m: FloatArray, across_x: BoolArray) -> NDArray[np.int64]:
    """(N,): which surface each point is on, counted from 0."""
    across = np.where(across_x, at_m[:, 0], at_m[:, 1])
    along = np.where(across_x, at_m[:, 1], at_m[:, 0])
    rows = np.floor(across / _ACROSS_M), np.floor(along / _ALONG_M)
    keys = (rows[0] * 4096.0 + rows[1]) * 2.0 + across_x
    return np.asarray(np.unique(keys, return_inverse=True)[1])
