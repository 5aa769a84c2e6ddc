"""Fits how a chair drives straight, from outputs and the positions that odometry measured. Pure.

Deadband, dead time, ramp and lag, as for turns (`model.py`), but stepped through time: the board
limits its outputs near obstacles, so the actual outputs are used.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.descent import Bounds, descend
from gazelink.settings_table import TABLE, index_of, profile_row

STEP_M = 0.5
"""Length of a step forward once tuned."""
_DT_S = 0.01
_SIGMA_M = 0.006  # of a measured position
_FEW = 20
_REST_S = 0.2  # at the beginning, the chair stands still
_LEAST_M, _MOST_OFF_M = 0.15, 0.03
_ROUNDS = 40
_STOP_SURE = 1.15  # safety factor on the measured stopping distance
_SHARES = (0.4, 0.6, 0.8, 1.0)
_FULL, _DEADBAND, _DEAD, _LAG, _ACCELERATE, _BRAKE = range(6)
# Prior means and spreads for chairs of this kind; sizes as logarithms.
_USUAL = np.array((math.log(0.35), 0.08, 0.15, math.log(0.3), math.log(0.6), math.log(0.9)))
_SPREAD = np.array((0.7, 0.04, 0.06, 0.35, 0.4, 0.4))
_LOW = np.array((math.log(0.05), 0.0, 0.02, math.log(0.05), math.log(0.15), math.log(0.15)))
_HIGH = np.array((math.log(2.0), 0.3, 0.4, math.log(0.8), math.log(3.0), math.log(4.0)))


@dataclass(frozen=True)
class ForwardRecording:
    """A straight press and the chair's response, until it rested again."""

    time_s: FloatArray
    """Of the outputs; each lasts until the next."""
    share: FloatArray
    """Of full deflection, forward positive."""
    measured_s: FloatArray
    way_m: FloatArray
    """Distance driven at `measured_s`, from any point before the press."""

    @classmethod
    def of(
        cls,
        outputs: Sequence[tuple[float, float]],
        places: Sequence[tuple[float, float, float]],
        begin_s: float,
        end_s: float,
    ) -> ForwardRecording:
        """From `outputs` (time, fraction) and `places` (time, x, y) between these times. Raises
        TuneError when there are too few."""
        driven = np.array([row for row in outputs if begin_s <= row[0] <= end_s]).reshape(-1, 2)
        seen = np.array([row for row in places if begin_s <= row[0] <= end_s]).reshape(-1, 3)
        if len(driven) < _FEW or len(seen) < _FEW:
            raise TuneError("too little was measured; end other programs and repeat")
        away = seen[:, 1:] - seen[0, 1:]
        length_m = math.hypot(*away[-1])
        along = away[-1] / length_m if length_m > _SIGMA_M else np.array((1.0, 0.0))
        return cls(driven[:, 0], driven[:, 1], seen[:, 0], away @ along)


@dataclass(frozen=True)
class ForwardNumbers:
    """Speeds in m/s at full deflection, forward."""

    full_m_s: float
    deadband: float
    dead_time_s: float
    lag_s: float
    accelerate_m_s2: float
    brake_m_s2: float

    def ways(self, share: FloatArray) -> FloatArray:
        """Distance after each step of `_DT_S` with outputs `share`, starting at rest."""
        return np.asarray(_ways(self._row()[None, :], share)[0])

    def _row(self) -> FloatArray:
        sizes = np.log((self.full_m_s, self.lag_s, self.accelerate_m_s2, self.brake_m_s2))
        return np.array((sizes[0], self.deadband, self.dead_time_s, *sizes[1:]))

    def stop_m(self, share: float) -> float:
        """Stopping distance after the output `share` ends, from its steady speed."""
        driven = np.full(round(4.0 / _DT_S), share)
        way = self.ways(np.concatenate((driven, np.zeros(round(4.0 / _DT_S)))))
        return float(way[-1] - way[len(driven) - 1])

    def speed_m_s(self, share: float) -> float:
        """Steady speed at the output `share`."""
        return self.full_m_s * max(0.0, share - self.deadband) / (1.0 - self.deadband)

    def brake_row_mm_s2(self, acts_s: float) -> int:
        """The braking with which a board that assumes a reaction time of `acts_s` computes no
        shorter stopping distance than this chair's, at any speed. Raises TuneError if none does."""
        _, _, low, high = TABLE[index_of(profile_row(0, "brake_mm_s2"))]
        brake = int(high)
        for share in _SHARES:
            speed, stop_m = self.speed_m_s(share), self.stop_m(share)
            rest_m = stop_m * _STOP_SURE - speed * acts_s
            if rest_m > 0.0:
                brake = min(brake, math.floor(1000.0 * speed**2 / (2.0 * rest_m)))
            if 1000.0 * speed**2 / (2.0 * low) + speed * acts_s < stop_m:
                raise TuneError(
                    f"it rolls on for {100 * stop_m:.0f} cm from {speed:.2f} m/s: weaker brakes"
                    " than this was made for"
                )
        return max(int(low), brake)

    def step_ms(self, permille: int, ramp_ms: int, most_ms: int) -> int:
        """Duration of a step of STEP_M on the board, including its ramps."""
        low, high = 2 * ramp_ms, most_ms
        while high - low > 5:
            middle = (low + high) // 2
            if self.step_m(permille, ramp_ms, middle) < STEP_M:
                low = middle
            else:
                high = middle
        return (low + high) // 2

    def step_m(self, permille: int, ramp_ms: int, step_ms: int) -> float:
        """Length of a step of that duration."""
        return float(self.ways(step_shares(permille, ramp_ms, step_ms))[-1])


def step_shares(permille: int, ramp_ms: int, step_ms: int) -> FloatArray:
    """The board's outputs during a step forward, until the chair rests."""
    ms = np.arange(0, step_ms, round(1000 * _DT_S)) + 5
    ramped = np.minimum(1.0, np.minimum(ms, step_ms + 1 - ms) / max(1, ramp_ms))
    return np.concatenate((permille / 1000.0 * ramped, np.zeros(round(3.0 / _DT_S))))


def _ways(rows: FloatArray, share: FloatArray) -> FloatArray:
    """Distances for several sets of unknowns (one row each): sets x steps."""
    full, lag, up, down = (np.exp(rows[:, at]) for at in (_FULL, _LAG, _ACCELERATE, _BRAKE))
    band = rows[:, _DEADBAND, None]
    times = np.arange(len(share)) * _DT_S
    late = np.arange(len(share) + 1)[None, :] * _DT_S - rows[:, _DEAD, None]
    edges, area = np.append(times, len(share) * _DT_S), np.append(0.0, np.cumsum(share))
    known = np.diff([np.interp(row, edges, area) for row in late], axis=1)  # means over each step
    requested = full[:, None] * np.clip((known - band) / (1.0 - band), 0.0, 1.0)
    follow = 1.0 - np.exp(-_DT_S / lag)
    ramp, speed, way = np.zeros(len(rows)), np.zeros(len(rows)), np.zeros(len(rows))
    out = np.empty((len(rows), len(share)))
    for step in range(len(share)):
        wanted = requested[:, step]
        before = speed
        ramp = ramp + np.clip(wanted - ramp, -down * _DT_S, up * _DT_S)
        speed = speed + (ramp - speed) * follow
        way = way + 0.5 * (before + speed) * _DT_S
        out[:, step] = way
    return out


@dataclass(frozen=True)
class _Laid:
    """A recording resampled to the steps of the model."""

    share: FloatArray
    at: FloatArray
    """Seconds since the first step, of each measured position."""
    way_m: FloatArray

    @classmethod
    def of(cls, recording: ForwardRecording) -> _Laid:
        begin_s = recording.time_s[0]
        steps = np.arange(begin_s, recording.time_s[-1], _DT_S)
        held = np.searchsorted(recording.time_s, steps, side="right") - 1
        at = recording.measured_s - begin_s
        pressed = recording.time_s[np.argmax(recording.share > 0.0)] - begin_s
        rest = (at <= pressed) & (at >= pressed - _REST_S)
        stood_m = float(recording.way_m[rest].mean()) if rest.any() else recording.way_m[0]
        kept = (at >= 0.0) & (at <= (len(steps) - 1) * _DT_S)
        return cls(recording.share[held], at[kept], recording.way_m[kept] - stood_m)


def identify(recordings: Sequence[ForwardRecording]) -> ForwardNumbers:
    """The chair's numbers. Raises TuneError when the recordings do not determine them."""
    laid = [_Laid.of(recording) for recording in recordings]
    if max(float(one.way_m[-1]) for one in laid) < _LEAST_M:
        raise TuneError("the chair hardly drove; is there free space ahead, is its profile slow?")

    def residuals(rows: FloatArray) -> FloatArray:
        found = []
        for one in laid:
            ways = _ways(rows, one.share)
            steps = np.arange(len(one.share)) * _DT_S
            modelled = np.stack([np.interp(one.at, steps, way) for way in ways])
            found.append((modelled - one.way_m) / _SIGMA_M)
        beliefs = (rows - _USUAL) / _SPREAD
        return np.concatenate((*found, beliefs), axis=1)

    def look(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        size = 1e-4
        seen = residuals(np.concatenate((at[None, :], at + size * np.eye(len(at)))))
        return seen[0], (seen[1:] - seen[0]).T / size

    data = sum(len(one.at) for one in laid)
    valley = descend(look, data, _USUAL, Bounds(_LOW, _HIGH, _SPREAD), _ROUNDS)
    off_m = _SIGMA_M * float(np.abs(residuals(valley.at[None, :])[0, :data]).max())
    if off_m > _MOST_OFF_M:
        raise TuneError(
            f"the chair did not drive as a chair does (off by {100 * off_m:.0f} cm); repeat on an"
            " even, firm floor, with nobody touching it"
        )
    row = valley.at
    sizes = np.exp(row[[_FULL, _LAG, _ACCELERATE, _BRAKE]])
    return ForwardNumbers(
        float(sizes[0]), float(row[_DEADBAND]), float(row[_DEAD]), *map(float, sizes[1:])
    )
