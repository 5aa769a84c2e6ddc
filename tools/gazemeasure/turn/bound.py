"""The time-optimal bound of a turn, computed with full knowledge of the chair.

Bang-bang on the twin with its true parameters and disturbances (model.py): full deflection
towards the setpoint, full deflection back, neutral. For each length of the counter-deflection the
first switch is found by secants so that the chair comes to rest at the setpoint; around it both
switches are searched together, coarse to fine (down to FINE_S), for the earliest settling in
the sense of judge.py. The dead time is part of it. tests/tools/test_measure_turn.py compares with
brute force over three switches: a third one gains 2 % at most, on a chair with stiction.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gazechair.base.arrays import FloatArray
from gazemeasure.turn.judge import WITHIN_DEG
from gazemeasure.turn.model import Case, Model, Switches, outcome

FINE_S = 0.003
_SECANTS = 5
_FEW = 3  # from a good guess
_TOGETHER = 120  # chairs simulated together, as long as the slowest of them needs
_COARSE, _FINE, _OFFSETS = 14, 9, 11


def bounds(cases: Sequence[Case]) -> FloatArray:
    """The bound of each case, s from the press; inf when none was found."""
    return best(cases)[0]


def best(cases: Sequence[Case]) -> tuple[FloatArray, FloatArray]:
    """The bounds, and per case both switches that give it, s, without dead time."""
    model = Model.of(cases)
    out, switches = np.empty(len(cases)), np.empty((len(cases), 2))
    order = np.argsort((model.angle / model.forward)[:, 0])
    for part in np.array_split(order, max(1, len(cases) // _TOGETHER)):
        settled, t1, t2 = _search(model.rows(part))
        out[part] = settled + model.dead[part, 0]
        switches[part] = np.hstack([t1, t2])
    return out, switches


def _search(model: Model) -> tuple[FloatArray, FloatArray, FloatArray]:
    full_s = model.forward / model.accelerate
    most = model.forward / model.brake + 2.0 * model.lag + full_s
    t2 = most * np.linspace(0.0, 1.0, _COARSE)[None, :]
    guess = model.angle / model.forward + 0.5 * full_s
    least, t1, t2 = _around(model, np.broadcast_to(guess, t2.shape), t2, _SECANTS)
    width = most / (_COARSE - 1)
    while float(width.max()) > FINE_S:
        near = np.maximum(0.0, t2 + width * np.linspace(-1.0, 1.0, _FINE)[None, :])
        found, new_t1, new_t2 = _around(model, np.broadcast_to(t1, near.shape), near, _FEW)
        better = (found < least)[:, None]
        least = np.minimum(found, least)
        t1 = np.where(better, new_t1, t1)
        t2 = np.where(better, new_t2, t2)
        width = width / 4
    return least, t1, t2


def _around(
    model: Model, t1: FloatArray, t2: FloatArray, secants: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Earliest settling per chair over the given t2 and, for each, t1 around the correct one."""
    t1 = _landing(model, t1, t2, secants)
    offsets = np.linspace(-1.0, 1.0, _OFFSETS) * WITHIN_DEG
    many_t1 = np.maximum(0.0, t1[:, :, None] + (offsets / model.forward)[:, None, :])
    many_t2 = np.broadcast_to(t2[:, :, None], many_t1.shape).reshape(len(t1), -1)
    many_t1 = many_t1.reshape(len(t1), -1)
    settled, _ = outcome(model, Switches.two(many_t1, many_t2))
    at = settled.argmin(axis=1)[:, None]
    take = np.take_along_axis
    return take(settled, at, 1)[:, 0], take(many_t1, at, 1), take(many_t2, at, 1)


def _landing(model: Model, t1: FloatArray, t2: FloatArray, secants: int) -> FloatArray:
    """The first switch with which the chair comes to rest at the setpoint, by secants."""
    before = t1
    missed = outcome(model, Switches.two(before, t2))[1] - model.angle
    now = np.maximum(0.0, before - missed / model.forward)
    for _ in range(secants):
        miss = outcome(model, Switches.two(now, t2))[1] - model.angle
        moved = np.where(now == before, 1.0, now - before)
        slope = np.maximum((miss - missed) / moved, 0.1 * model.forward)
        before, missed = now, miss
        now = np.maximum(0.0, now - miss / slope)
    return now
