"""Least squares within bounds by Levenberg and Marquardt's method, with Huber's weights.

The weights fall off for data far away. The damping is scaled by the unknowns' natural sizes, not by
the data's sensitivity to them: an unknown with hardly any effect at a point (the casters' position
at the end of their swing) would otherwise take every step, and too far.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray

_HUBER = 2.0  # residuals beyond this count linearly
_DAMPING = 100.0
_DAMPING_MOST = 1e9
_EASES, _STIFFENS = 5.0, 6.0  # after a step that helped, and one that did not
_ENOUGH = 1e-6  # fraction by which a step must lower the cost to continue


@dataclass(frozen=True)
class Valley:
    """Where a descent ended."""

    cost: float
    at: FloatArray
    covariance: FloatArray


@dataclass(frozen=True)
class Bounds:
    """Limits of the unknowns, and the natural size of each."""

    low: FloatArray
    high: FloatArray
    size: FloatArray

    def clipped(self, at: FloatArray) -> FloatArray:
        """The nearest point within."""
        return np.clip(at, self.low, self.high)

    def step(self, at: FloatArray, squares: FloatArray, down: FloatArray) -> FloatArray:
        """The point after the step that solves `squares` x step = `down`; unknowns that would leave
        the bounds stay on them, and the others are solved given that."""
        to = at.copy()
        free = np.ones(len(at), dtype=bool)
        while free.any():
            rest = down[free] - squares[np.ix_(free, ~free)] @ (to - at)[~free]
            to[free] = at[free] + np.linalg.solve(squares[np.ix_(free, free)], rest)
            beyond = free & ((to < self.low) | (to > self.high))
            if not beyond.any():
                break
            to = self.clipped(to)
            free &= ~beyond
        return to


Look = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""The residuals at a point and their Jacobian."""


def descend(look: Look, data: int, start: FloatArray, bounds: Bounds, rounds: int) -> Valley:
    """The minimum below `start`, after at most `rounds` steps. The first `data` residuals are
    data, which may contain outliers; the others always count in full."""
    at = bounds.clipped(start)
    scale = np.diag(bounds.size**-2.0)
    damping = _DAMPING
    residual, jacobian = look(at)
    cost, weights = _weighed(residual, data)
    for _ in range(rounds):
        squares = (jacobian * weights[:, None]).T @ jacobian
        down = -jacobian.T @ (weights * residual)
        trial = bounds.step(at, squares + damping * scale, down)
        seen, steep = look(trial)
        there, heavy = _weighed(seen, data)
        if there < cost:
            gain = cost - there
            at, residual, jacobian, cost, weights = trial, seen, steep, there, heavy
            damping /= _EASES
            if gain < _ENOUGH * cost:
                break
        else:
            damping *= _STIFFENS
            if damping > _DAMPING_MOST:
                break
    squares = (jacobian * weights[:, None]).T @ jacobian
    return Valley(cost, at, np.asarray(np.linalg.inv(squares)))


def _weighed(residual: FloatArray, data: int) -> tuple[float, FloatArray]:
    size = np.abs(residual)
    weights = np.minimum(1.0, _HUBER / np.maximum(size, 1e-9))
    weights[data:] = 1.0
    cost = np.where(weights < 1.0, _HUBER * (2 * size - _HUBER), size**2).sum()
    return float(cost), weights
