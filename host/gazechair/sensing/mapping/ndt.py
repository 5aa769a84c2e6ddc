"""Fine fit of a scan: least squares of its points to normal distributions in a grid (NDT).

Each cell holds mean and covariance of the known points in and around it; along a wall a point may
slide, across it not (Biber and Strasser, The normal distributions transform, 2003).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.sensing.mapping.poses import rotation

_CELL_M = 0.10
_LEAST_POINTS = 4
_NOISE_M = 0.02
_ITERATIONS = 12
_LOOSE_ITERATIONS = 4
_SETTLED = 1e-4  # metres, radians
_LONGEST_STEP_M = 0.05
# Squared deviations (Mahalanobis): beyond them a point counts ever less; first, then last.
_LOOSE, _TIGHT = 12.0, 4.0
_FITS = 6.0  # a point nearer than this lies on what is known
_DAMPING = 1e-3
# Neighbouring points err together: so many of them tell no more than one. Scales the prior only.
_CORRELATED = 10.0


@dataclass(frozen=True)
class Fit:
    """A fitted pose and what it is worth."""

    pose: FloatArray
    """(3,): x, y in metres, heading in radians."""
    information: FloatArray
    """(3, 3): how firmly the points determine the pose; only its proportions mean something."""
    score: float
    """Share of the points that lie on what is known, 0..1."""


class NdtGrid:
    """Normal distributions of the known points (N, 2)."""

    def __init__(self, known_m: FloatArray) -> None:
        cells = np.floor(known_m / _CELL_M).astype(np.int64)
        self._low = cells.min(axis=0) - 1
        self._shape = cells.max(axis=0) + 2 - self._low
        cells -= self._low
        size = int(self._shape[0] * self._shape[1])
        index = cells[:, 0] * self._shape[1] + cells[:, 1]
        middle = known_m.mean(axis=0)  # sums of squares about it keep their digits
        x, y = (known_m - middle).T
        count, sx, sy, sxx, sxy, syy = (
            _summed_around(np.bincount(index, weights, size).reshape(self._shape))
            for weights in (np.ones(len(x)), x, y, x * x, x * y, y * y)
        )
        some = np.maximum(count, 1.0)
        mx, my = sx / some, sy / some
        vxx, vyy = sxx / some - mx * mx + _NOISE_M**2, syy / some - my * my + _NOISE_M**2
        vxy = sxy / some - mx * my
        determinant = vxx * vyy - vxy * vxy
        self._known = count >= _LEAST_POINTS
        self._mean = np.stack((mx, my), axis=-1) + middle
        self._weight = np.stack((vyy, -vxy, vxx), axis=-1) / determinant[..., None]

    def at(self, points_m: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """For each point: whether its cell is known, offset from its mean (N, 2), weights (N, 3).

        Weights: xx, xy, yy of the inverse covariance.
        """
        cells = np.floor(points_m / _CELL_M).astype(np.int64) - self._low
        inside = ((cells >= 0) & (cells < self._shape)).all(axis=1)
        i, j = np.where(inside[:, None], cells, 0).T
        return inside & self._known[i, j], points_m - self._mean[i, j], self._weight[i, j]


def fit(
    grid: NdtGrid, points_m: FloatArray, pose: FloatArray, deviations: FloatArray | None = None
) -> Fit:
    """Gauss-Newton from `pose`; `deviations` (3,), m, m, rad: how far it may be from `pose`."""
    start = pose
    hold = np.zeros(3) if deviations is None else _CORRELATED * deviations**-2.0
    for iteration in range(_ITERATIONS):
        turned = points_m @ rotation(pose[2]).T
        known, offset, weights = grid.at(turned + pose[:2])
        wxx, wxy, wyy = weights.T
        ox, oy = offset.T
        squared = np.where(known, wxx * ox * ox + 2.0 * wxy * ox * oy + wyy * oy * oy, np.inf)
        limit = _LOOSE if iteration < _LOOSE_ITERATIONS - 1 else _TIGHT
        robust = 1.0 / (1.0 + squared / limit) ** 2
        wxx, wxy, wyy = robust * wxx, robust * wxy, robust * wyy
        tx, ty = -turned[:, 1], turned[:, 0]  # how a point moves as the heading grows
        gx, gy = wxx * tx + wxy * ty, wxy * tx + wyy * ty
        information = np.array(
            (
                (wxx.sum(), wxy.sum(), gx.sum()),
                (wxy.sum(), wyy.sum(), gy.sum()),
                (gx.sum(), gy.sum(), (tx * gx + ty * gy).sum()),
            )
        )
        px, py = wxx * ox + wxy * oy, wxy * ox + wyy * oy
        pull = hold * (start - pose) - np.array((px.sum(), py.sum(), (tx * px + ty * py).sum()))
        step = np.linalg.solve(information + np.diag(hold + _DAMPING), pull)
        length_m = math.hypot(step[0], step[1])
        if length_m > _LONGEST_STEP_M:
            step *= _LONGEST_STEP_M / length_m
        pose = pose + step
        if iteration >= _LOOSE_ITERATIONS and np.abs(step).max() < _SETTLED:
            break
    return Fit(pose, information, float((squared < _FITS).mean()))


def _summed_around(part: FloatArray) -> FloatArray:
    wide = np.pad(part, 1)
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])
