"""Finds a chair's numbers from recorded pulses: the model's least disagreement with all of them.

Levenberg and Marquardt's method, with weights that fall off for samples far away (Huber), from
several starts. What comparable chairs are like (a spread for every unknown) counts as much as a
few samples: it decides only what the pulses leave open.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gazechair.tune import model
from gazechair.tune.model import Pulses
from gazechair.tune.numbers import TurnNumbers
from gazechair.tune.recording import Recording

Floats = NDArray[np.float64]

_NOISE_DEG = 0.6  # what a sample may be off: the floor's doing, in which neighbours agree
_HUBER = 2.0
_STUCK_DPS = 0.5  # what a ramp may be off the speed at which the chair breaks loose
_ROUNDS = (10, 40)  # of every start, and of the best three
# How the casters lie at first, and how many degrees they do.
_STARTS = ((0.0, 0.0), (0.0, 8.0), (0.0, -8.0), (1.0, 8.0), (1.0, -8.0), (0.5, 8.0), (0.5, -8.0))
_BRISK = (4.8, 1.0)  # a chair that starts at once: its ramp, log degrees/s2, and its stiction
_EVERY = 2  # samples: neighbours say little new
_STEP = 1e-4
# Spread about what is believed of the profile; sizes and times as logarithms.
_SPREAD = np.array([0.25, 0.25, 0.05, 0.15, 0.5, 0.5, 0.35, 6.0, 6.0, 0.6, 0.5, 0.7])
_LOOSE_SHARE = 0.8  # of the full speed at most is needed to break loose: it turned
_LOW = np.array([1.0, 1.0, 0.0, 0.02, -4.0, 3.0, 3.0, 0.0, -20.0, 0.5, 0.0, -4.0])
_HIGH = np.array([5.5, 5.5, 0.3, 0.4, -0.2, 6.2, 6.2, 29.0, 20.0, 5.0, 1.0, 4.0])


@dataclass(frozen=True)
class Fit:
    """What was found, and how well."""

    numbers: TurnNumbers
    residual_deg: float
    """Root mean square of what the model leaves unexplained."""
    spread: TurnNumbers
    """Standard error of each number, as a share of it (of the deadband and dead time: as is)."""


def identify(recordings: Sequence[Recording], believed: TurnNumbers) -> Fit:
    """The numbers that explain the recordings best."""
    pulses = _thinned(Pulses.of(recordings))
    centre = _unknowns(believed)
    tried = []
    for lie, caster in _STARTS:
        for brisk in (False, True):
            start = centre.copy()
            start[model.LIE], start[model.CASTER] = lie, caster
            if brisk:
                start[[model.ACCELERATE, model.BREAKAWAY]] = _BRISK
            tried.append(_descend(start, centre, pulses, _ROUNDS[0]))
    tried.sort(key=lambda valley: valley[0])
    best = min(
        (_descend(valley[1], centre, pulses, _ROUNDS[1]) for valley in tried[:3]),
        key=lambda valley: valley[0],
    )
    _, unknowns, covariance = best
    residual = model.headings(unknowns[None], pulses)[0] - pulses.heading_deg
    errors = np.sqrt(np.diag(covariance))
    return Fit(
        _numbers(unknowns),
        float(np.sqrt(np.nanmean(residual**2))),
        TurnNumbers(*errors[:8].tolist()),
    )


def _unknowns(n: TurnNumbers) -> Floats:
    sizes = np.log([n.left_dps, n.right_dps, n.lag_s, n.accelerate_dps2, n.brake_dps2])
    way = np.log(0.25 * (n.left_dps + n.right_dps))  # half a second at full speed
    left, right, lag, accelerate, brake = sizes
    return np.array(
        [
            *(left, right, n.deadband, n.dead_time_s, lag, accelerate, brake, n.breakaway_dps),
            *(0.0, way, 0.5, 0.0),
        ]
    )


def _numbers(u: Floats) -> TurnNumbers:
    left, right, lag, accelerate, brake = np.exp(
        u[[model.LEFT, model.RIGHT, model.LAG, model.ACCELERATE, model.BRAKE]]
    )
    return TurnNumbers(
        float(left),
        float(right),
        float(u[model.DEADBAND]),
        float(u[model.DEAD]),
        float(lag),
        float(accelerate),
        float(brake),
        min(float(u[model.BREAKAWAY]), _LOOSE_SHARE * min(float(left), float(right))),
        float(u[model.CASTER]),
        float(np.exp(u[model.CASTER_WAY])),
    )


def _thinned(p: Pulses) -> Pulses:
    times, headings = p.time_s[:, ::_EVERY].copy(), p.heading_deg[:, ::_EVERY].copy()
    return replace(p, time_s=times, heading_deg=headings)


def _descend(
    start: Floats, centre: Floats, pulses: Pulses, rounds: int
) -> tuple[float, Floats, Floats]:
    """(cost, unknowns, their covariance) of the valley below `start`."""
    known = np.isfinite(pulses.heading_deg)
    wanted = pulses.heading_deg[known]
    nudges = np.vstack([np.zeros(model.UNKNOWNS), np.eye(model.UNKNOWNS) * _STEP])
    now = np.clip(start, _LOW, _HIGH)
    damping = 1e-2
    cost, jacobian, residual, weights = _look(now, centre, pulses, known, wanted, nudges)
    for _ in range(rounds):
        squares = (jacobian * weights[:, None]).T @ jacobian
        slope = jacobian.T @ (weights * residual)
        step = np.linalg.solve(squares + damping * np.diag(np.diag(squares)), -slope)
        trial = np.clip(now + step, _LOW, _HIGH)
        seen = _look(trial, centre, pulses, known, wanted, nudges)
        if seen[0] < cost:
            gain = cost - seen[0]
            now, damping = trial, damping / 5
            cost, jacobian, residual, weights = seen
            if gain < 1e-6 * cost:
                break
        else:
            damping *= 6
            if damping > 1e6:
                break
    squares = (jacobian * weights[:, None]).T @ jacobian
    covariance: Floats = np.linalg.inv(squares).astype(np.float64)
    return cost, now, covariance


def _look(
    at: Floats,
    centre: Floats,
    pulses: Pulses,
    known: NDArray[np.bool_],
    wanted: Floats,
    nudges: Floats,
) -> tuple[float, Floats, Floats, Floats]:
    """Cost, Jacobian, residuals and weights at `at`; the beliefs are the last rows."""
    seen = model.headings(at + nudges, pulses)[:, known] / _NOISE_DEG
    seen = np.hstack((seen, model.excess_dps(at + nudges, pulses) / _STUCK_DPS))
    wanted = np.concatenate((wanted / _NOISE_DEG, np.zeros(len(pulses.seconds))))
    residual = np.concatenate((seen[0] - wanted, (at - centre) / _SPREAD))
    columns = ((seen[1:] - seen[0]) / _STEP).T
    jacobian = np.vstack([columns, np.diag(1.0 / _SPREAD)])
    size = np.abs(residual)
    weights = np.minimum(1.0, _HUBER / np.maximum(size, 1e-9))
    weights[-model.UNKNOWNS :] = 1.0
    cost = float(np.where(weights < 1.0, _HUBER * (2 * size - _HUBER), size**2).sum())
    return cost, jacobian, residual, weights
