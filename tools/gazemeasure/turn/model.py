"""The twin's turning for many chairs and switch times at once: gazesim's model in numpy.

The same rules as gazesim.chair_axis and gazesim.disturbances, in steps of STEP_S, for a stick that
is always at full deflection or neutral; a test compares both.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray, IntArray
from gazemeasure.turn.judge import FOR_MS, UNDER_DPS, WITHIN_DEG
from gazesim.chair import Parameters
from gazesim.disturbances import Floor

STEP_S = 0.004
_COAST_S = 1.2  # after the last switch: until it has come to rest
_CHUNK = 20_000  # candidates at a time, to fit into the processor's cache
_VEER_EVERY_S = 0.1
_VEERS = 150


@dataclass(frozen=True)
class Case:
    """One turn: the chair, the angle (left positive, degrees), and the seed of its floor.

    `begins_s`: the chair's time at the press, on which its floor depends; it stood until then.
    """

    parameters: Parameters
    angle_deg: float
    seed: int = 1
    begins_s: float = 0.0


@dataclass(frozen=True)
class Switches:
    """When to switch, s, without dead time: towards for t1, back for t2, towards for t3."""

    t1: FloatArray
    t2: FloatArray
    t3: FloatArray

    @classmethod
    def two(cls, t1: FloatArray, t2: FloatArray) -> Switches:
        """Two switches, without the third."""
        return cls(t1, t2, np.zeros_like(t1))


@dataclass(frozen=True)
class Model:
    """The chairs' turning as columns (one row per chair), in the direction of the turn."""

    angle: FloatArray
    sign: FloatArray
    forward: FloatArray
    back: FloatArray
    accelerate: FloatArray
    brake: FloatArray
    lag: FloatArray
    standstill: FloatArray
    friction: FloatArray
    breakaway: FloatArray
    dead: FloatArray
    slope: FloatArray
    downhill: FloatArray
    caster: FloatArray
    caster_s: FloatArray
    left: FloatArray
    lie: FloatArray
    begins: FloatArray
    veers: FloatArray

    @classmethod
    def of(cls, cases: Sequence[Case]) -> Model:
        """Columns from `cases`."""
        rows = [_row(case) for case in cases]
        columns = [np.array(column)[:, None] for column in zip(*rows, strict=True)]
        columns.append(np.array([_veers(case) for case in cases]))
        return cls(*columns)

    def rows(self, which: IntArray) -> Model:
        """Some of the chairs."""
        return Model(*(getattr(self, name)[which] for name in self.__dataclass_fields__))


def _row(case: Case) -> tuple[float, ...]:
    d = case.parameters.disturbances
    a = d.axis(case.parameters.turn)
    left = case.angle_deg > 0
    towards, away = (a.positive, a.negative) if left else (a.negative, a.positive)
    # In the order of gazesim.disturbances.Floor: the casters for turning come second.
    lie = Floor(case.seed)._lie[1]
    sign = 1.0 if left else -1.0
    return (
        *(abs(case.angle_deg), sign, towards, away, a.accelerate, a.brake, a.lag_s, a.standstill),
        *(a.friction, max(a.stiction, a.friction, a.standstill), a.dead_time_s),
        *(d.slope_deg_s, d.downhill_deg, d.caster_deg, d.caster_s, a.positive, lie, case.begins_s),
    )


def _veers(case: Case) -> list[float]:
    """Relative veer of the turn in each tenth of a second of the chair's time."""
    spread = case.parameters.disturbances.veer
    floor = Floor(case.seed)
    out = []
    for _ in range(_VEERS):
        if spread:
            floor.wander(_VEER_EVERY_S, spread)
        out.append(floor.veer[1])
    return out


def outcome(model: Model, switches: Switches) -> tuple[FloatArray, FloatArray]:
    """Per chair (row) and candidate (column): settling time, s without dead time (inf: never);
    and the heading at rest, degrees in the direction of the turn."""
    rows, columns = switches.t1.shape
    per = max(1, _CHUNK // rows)
    parts = [
        _simulate(model, *(t[:, at : at + per] for t in (switches.t1, switches.t2, switches.t3)))
        for at in range(0, columns, per)
    ]
    return (
        np.concatenate([settled for settled, _ in parts], axis=1),
        np.concatenate([end for _, end in parts], axis=1),
    )


def _simulate(
    m: Model, t1: FloatArray, t2: FloatArray, t3: FloatArray
) -> tuple[FloatArray, FloatArray]:
    ramp_at, rest_s = _ramps(m, t1, t2, t3)
    follow = 1.0 - np.exp(-STEP_S / m.lag)
    up = m.forward / (m.forward - m.friction)
    down = m.back / (m.back - m.friction)
    rough = bool(m.friction.any())
    uneven = bool(m.veers.any() or m.slope.any() or m.caster.any())
    shape = t1.shape
    speed, yaw, heading = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    lie = np.broadcast_to(m.lie, shape)
    ramp = np.zeros(shape)
    since, settled = np.full(shape, np.inf), np.full(shape, np.inf)
    steps = math.ceil((rest_s + _COAST_S + FOR_MS / 1000) / STEP_S)
    for step in range(1, steps + 1):
        now = step * STEP_S
        before, ramp = ramp, ramp_at(now)
        drive = 0.5 * (before + ramp)
        if rough:
            drive = np.maximum(0.0, drive - m.friction) * up + (
                np.minimum(0.0, drive + m.friction) * down
            )
        held = np.abs(ramp) < m.breakaway
        new = speed + (drive - speed) * follow
        slow = (np.abs(new) < m.standstill) & (np.abs(drive) < m.standstill)
        stuck = held & ((speed == 0.0) | (new * speed < 0.0))
        new = np.where(slow | stuck, 0.0, new)
        if uneven:
            moved, lie = _over_floor(m, now, new, heading, lie)
        else:
            moved = new
        heading = heading + 0.5 * STEP_S * (yaw + moved)
        speed, yaw = new, moved
        good = (np.abs(heading - m.angle) <= WITHIN_DEG) & (np.abs(yaw) < UNDER_DPS)
        since = np.where(good, np.minimum(since, now), np.inf)
        settled = np.where(now - since >= FOR_MS / 1000, np.minimum(settled, since), settled)
        if rest_s < now < rest_s + _COAST_S and not speed.any():  # for good
            return np.minimum(settled, since), heading
    return settled, heading


def _ramps(
    m: Model, t1: FloatArray, t2: FloatArray, t3: FloatArray
) -> tuple[Callable[[float], FloatArray], float]:
    """The ramp of the chair's own controller as a function of time, and when it is back at zero.

    Each phase is a trapezoid: up with `accelerate` from where the previous one reaches zero, down
    with `brake` from its switch on.
    """
    a, b = m.accelerate, m.brake
    phases = []
    begin, switch = np.zeros_like(t1), t1
    for sign, full, longer in ((1.0, m.forward, t2), (-1.0, m.back, t3), (1.0, m.forward, 0.0)):
        peak = np.clip(a * (switch - begin), 0.0, full)
        phases.append((sign, full, begin, switch, peak))
        begin = np.maximum(begin, switch) + peak / b
        switch = switch + longer
    if not t3.any():
        phases.pop()

    def at(now: float) -> FloatArray:
        total = np.zeros_like(t1)
        for sign, full, begin, switch, peak in phases:
            rising = np.minimum(a * (now - begin), full)
            total += sign * np.maximum(0.0, np.minimum(rising, peak - b * (now - switch)))
        return total

    return at, float(begin.max())


def _over_floor(
    m: Model, now: float, speed: FloatArray, heading: FloatArray, lie: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """The yaw rate on this floor, and the casters' position."""
    tenth = np.minimum((m.begins + m.dead + now) / _VEER_EVERY_S, _VEERS - 1).astype(np.int64)
    veer = np.take_along_axis(m.veers, tenth, 1)
    downhill = np.radians(m.downhill - m.sign * heading)
    share = m.sign * speed / m.left
    swinging = (share != 0.0) & (lie * share < np.abs(share))
    new = np.where(swinging, np.clip(lie + 2.0 * share * STEP_S / m.caster_s, -1.0, 1.0), lie)
    swung = np.sin(0.5 * np.pi * new) - np.sin(0.5 * np.pi * lie)
    extra = m.slope * np.sin(downhill) + 0.5 * m.caster * swung / STEP_S
    yaw = np.where(speed != 0.0, speed * (1.0 + veer) + m.sign * extra, 0.0)
    return yaw, new
