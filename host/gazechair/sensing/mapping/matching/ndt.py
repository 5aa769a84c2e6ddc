"""Fine fit of a scan: least squares of its points to normal distributions in a grid (NDT).

Each cell holds mean and covariance of the known points in and around it; along a wall a point may
slide, across it not (Biber and Strasser, The normal distributions transform, 2003).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray, Int32Array, IntArray
from gazechair.base.poses import rotation
from gazechair.sensing.mapping.matching.faces import sides_of

_CELL_M = 0.10
_LEAST_POINTS = 4
_NOISE_M = 0.02
_ITERATIONS = 12
_LOOSE_ITERATIONS = 4
_SETTLED = 1e-4  # metres, radians
_LONGEST_STEP_M = 0.05
# Squared deviations (Mahalanobis): beyond them a point counts ever less; first, then last.
_LOOSE, _TIGHT = 12.0, 4.0
_FITS = 6.0  # a point with less lies on a known surface
_DAMPING = 1e-3
# Errors of neighbouring points are correlated: this many count as one. Scales the prior only.
CORRELATED = 10.0


@dataclass(frozen=True)
class Fit:
    """A fitted pose and its quality."""

    pose: FloatArray
    """(3,): x, y in metres, heading in radians."""
    information: FloatArray
    """(3, 3): how firmly the points determine the pose; only its proportions are meaningful."""
    score: float
    """Share of the points that lie on known surfaces, 0..1."""


class NdtGrid:
    """Normal distributions of the known points (N, 2)."""

    def __init__(self, known_m: FloatArray, faces: BoolArray | None = None) -> None:
        """`faces`: see faces_of; a surface then counts only for points seen from its side."""
        cells = np.floor(known_m / _CELL_M).astype(np.int64)
        self._low = cells.min(axis=0) - 1
        self._shape = cells.max(axis=0) + 2 - self._low
        cells -= self._low
        index = cells[:, 0] * self._shape[1] + cells[:, 1]
        self._faced = faces is not None
        layers = [np.ones(len(known_m), dtype=bool)] if faces is None else list(faces.T)
        # By layer and cell: where its distribution is in those below, the first being none.
        self._at = np.zeros((len(layers), *self._shape), dtype=np.int32)
        means, weights = [np.zeros((1, 2))], [np.zeros((1, 3))]
        count = 1
        for at, one in zip(self._at, layers, strict=True):
            known, mean, weight = _distributions(known_m[one], index[one], at.shape)
            at[known] = np.arange(count, count + len(mean))
            means.append(mean)
            weights.append(weight)
            count += len(mean)
        self._mean, self._weight = np.concatenate(means), np.concatenate(weights)

    def at(
        self, points_m: FloatArray, towards: FloatArray | None
    ) -> tuple[BoolArray, FloatArray, FloatArray, FloatArray]:
        """For each point: (known there, offset (N, 2), weights (N, 3), squared deviation).

        Uses the best-fitting distribution of those that are visible from `towards` (N, 2).
        Weights: xx, xy, yy of the inverse covariance.
        """
        cells = np.floor(points_m / _CELL_M).astype(np.int64) - self._low
        inside = ((cells >= 0) & (cells < self._shape)).all(axis=1)
        i, j = np.where(inside[:, None], cells, 0).T
        if not self._faced or towards is None:
            return self._of(points_m, np.where(inside, self._at[0, i, j], 0))
        both = [
            self._of(points_m, np.where(inside, self._at[side, i, j], 0))
            for side in sides_of(towards).T
        ]
        second = both[1][3] < both[0][3]
        known, offset, weight, squared = (
            np.where(second if one.ndim == 1 else second[:, None], other, one)
            for one, other in zip(*both, strict=True)
        )
        return known, offset, weight, squared

    def _of(
        self, points_m: FloatArray, which: Int32Array
    ) -> tuple[BoolArray, FloatArray, FloatArray, FloatArray]:
        offset, weight, known = points_m - self._mean[which], self._weight[which], which > 0
        ox, oy = offset.T
        wxx, wxy, wyy = weight.T
        squared = np.where(known, wxx * ox * ox + 2.0 * wxy * ox * oy + wyy * oy * oy, np.inf)
        return known, offset, weight, squared


def fit(
    grid: NdtGrid,
    points_m: FloatArray,
    pose: FloatArray,
    deviations: FloatArray | None = None,
    origins_m: FloatArray | None = None,
) -> Fit:
    """Gauss-Newton from `pose`; `deviations` (3,), m, m, rad: how far it may be from `pose`.

    `origins_m`, (N, 2) or (2,): from where the points were seen; a grid with faces needs it.
    """
    start = pose
    hold = np.zeros(3) if deviations is None else CORRELATED * deviations**-2.0
    for iteration in range(_ITERATIONS):
        turn = rotation(pose[2]).T
        turned = points_m @ turn
        towards = None if origins_m is None else (origins_m - points_m) @ turn
        _, offset, weights, squared = grid.at(turned + pose[:2], towards)
        wxx, wxy, wyy = weights.T
        ox, oy = offset.T
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


def _distributions(
    known_m: FloatArray, index: IntArray, shape: tuple[int, ...]
) -> tuple[BoolArray, FloatArray, FloatArray]:
    """(which cells are known, and of these means (M, 2) and weights (M, 3))."""
    middle = known_m.mean(axis=0) if len(known_m) else np.zeros(2)
    size = math.prod(shape)
    x, y = (known_m - middle).T  # sums of squares about it keep their digits
    sums = [
        _summed_around(np.bincount(index, weights, size).reshape(shape).astype(np.float64))
        for weights in (np.ones(len(x)), x, y, x * x, x * y, y * y)
    ]
    known = sums[0] >= _LEAST_POINTS
    count, sx, sy, sxx, sxy, syy = (one[known] for one in sums)
    mx, my = sx / count, sy / count
    vxx, vyy = sxx / count - mx * mx + _NOISE_M**2, syy / count - my * my + _NOISE_M**2
    vxy = sxy / count - mx * my
    weight = np.stack((vyy, -vxy, vxx), axis=-1) / (vxx * vyy - vxy * vxy)[:, None]
    return known, np.stack((mx, my), axis=-1) + middle, weight


def _summed_around(part: FloatArray) -> FloatArray:
    wide = np.pad(part, 1)
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    return np.asarray(rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:])
