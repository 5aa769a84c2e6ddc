"""The response of a chair at rest to one joystick pulse, in closed form.

Deadband, dead time, ramp, stiction and lag as in numbers.TurnNumbers, in the order of the board's
own model. The ramp of a pulse is a trapezoid, a sum of four ramps that begin one
after the other; the heading is the sum of their answers: a ramp of slope 1 through a lag of L
seconds turns x**2/2 - L*x + L**2*(1 - exp(-x/L)) in x seconds. The chair stands until the ramp
breaks it loose; the first ramp then begins with a jump, and a jump of 1 turns x - L*(1 -
exp(-x/L)). Once the ramp is back at zero, the brakes hold the chair as soon as it is slow.

Friction, which the board's model does not have, takes a constant speed off the ramp; full
deflection gives the full speed all the same. A pulse began at any time between two heading
samples, so each has a delay of its own. Both are found along with the numbers: without friction
the full speeds came out 2 % low and the brake 5 %, and with pulses taken to begin midway between
two samples one side's full speed came out 1 to 2 % higher than the other's.

Whether a pulse sets the chair in motion is taken from the recording (`readings`), not worked out,
so that the headings follow the numbers smoothly; `excess_dps` tells what the numbers say about it.

Casters, which swing round after a reversal as the wheels move, turn the chair, too: half a cosine
over the first degrees after the reversal. A sloping floor turns it a little while it moves, more
when it stands across the slope; and each pulse has its own piece of floor, on which the wheels turn
it some percent more or less than on the others. All of this is fitted along with the rest, so that
it does not distort the rest, and then discarded.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording

# The columns of a set of unknowns of a chair; those of size and time as logarithms. SLOPE in
# degrees/s, BEND in degrees/s per radian.
LEFT, RIGHT, DEADBAND, DEAD, LAG, ACCELERATE, BRAKE, BREAKAWAY = range(8)
CASTER, CASTER_WAY, LIE, SLOPE, BEND, FRICTION = range(8, 14)
UNKNOWNS = 14
_OF_WHEELS = [*range(CASTER), FRICTION]
_STUCK_DEG = 0.09  # more than a step of the sensor and its drift
_TURNED_DEG = 0.3
_DOUBTFUL = 3  # pulses in between; where there are more, the sensor is noisy
# Below this speed a slope turns the chair less and less: below half of it the brakes hold it, and a
# step there would make the headings discontinuous.
_SLOW_DPS = 1.0
_STILL_DPS = 0.5  # below this, a released chair is stopped by its brakes, as in the board's model


@dataclass(frozen=True)
class Pulses:
    """Recordings as arrays: one row each, columns in time."""

    deflection: FloatArray
    """Column: -1..1, left positive."""
    full: FloatArray
    """Column: the deflection that gives the full speed to that side, without sign."""
    seconds: FloatArray
    """Column: duration."""
    time_s: FloatArray
    """Since the wiper moved; rows are padded with their last sample."""
    heading_deg: FloatArray
    """Since then; nan where padded, and all of it when the chair stuck."""
    turned: BoolArray
    """Column: whether it turned the chair."""
    away_rad: FloatArray
    """Recorded heading since the first pulse: a slope's direction changes with it."""

    @classmethod
    def of(cls, recordings: Sequence[Recording], turned: Sequence[bool]) -> Pulses:
        """All rows as long as the longest; `turned`: one of readings()."""
        columns = max(len(r.time_s) for r in recordings)
        times = np.empty((len(recordings), columns))
        headings = np.full((len(recordings), columns), np.nan)
        away = np.zeros((len(recordings), columns))
        start_deg = 0.0
        for row, r in enumerate(recordings):
            n = len(r.time_s)
            away[row, :n] = np.radians(start_deg + r.heading_deg)
            start_deg += r.turned_deg
            times[row, :n], times[row, n:] = r.time_s, r.time_s[-1]
            headings[row, :n] = r.heading_deg if turned[row] else np.nan
        return cls(
            np.array([[r.deflection] for r in recordings]),
            np.array([[r.full_deflection] for r in recordings]),
            np.array([[r.pulse_s] for r in recordings]),
            times,
            headings,
            np.array([[moved] for moved in turned]),
            away,
        )


def readings(recordings: Sequence[Recording]) -> list[tuple[bool, ...]]:
    """Whether each pulse turned the chair: all interpretations, the likeliest first.

    A pulse with almost no effect may have failed to break the chair loose, or have turned the
    wheels while the casters cancelled all of it.
    """
    most = [float(np.abs(r.heading_deg).max()) for r in recordings]
    both = [_STUCK_DEG < m < _TURNED_DEG for m in most]
    if sum(both) > _DOUBTFUL:
        both = [False] * len(most)
    ways = [
        (False, True) if doubtful else (m >= _TURNED_DEG,)
        for m, doubtful in zip(most, both, strict=True)
    ]
    return list(product(*ways))


def headings(unknowns: FloatArray, pulses: Pulses) -> FloatArray:
    """Heading of every sample for every row of `unknowns`: sets x pulses x samples, degrees.

    A row: the chair's unknowns (UNKNOWNS), then the share by which each pulse turned further, then
    the delay of each, s.
    """
    u = unknowns[:, :UNKNOWNS, None, None]
    further, late_s = of_pulses(unknowns)
    gain = 1.0 + further
    left = pulses.deflection > 0
    sign = np.where(left, 1.0, -1.0)
    # Rows that differ in something else have the same wheels, which take the longest.
    same = (unknowns[:, _OF_WHEELS] == unknowns[0, _OF_WHEELS]).all(axis=1)
    same &= (late_s == late_s[0]).all(axis=(1, 2))
    same[0] = False
    wheels, moved_s = _wheels(u[~same], pulses, late_s[~same])
    of = np.where(same, 0, np.cumsum(~same) - 1)
    wheels, moved_s = wheels[of], moved_s[of]
    swung = _casters(u, wheels, left[:, 0])
    slid = np.cumsum((u[:, SLOPE] + u[:, BEND] * pulses.away_rad) * moved_s, axis=2)
    return sign * (gain * wheels + u[:, CASTER] * swung) + slid


def of_pulses(unknowns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The fraction by which each pulse turned further, and its delay, s: sets x pulses x 1."""
    further, late_s = np.split(unknowns[:, UNKNOWNS:, None], 2, axis=1)
    return further, late_s


def excess_dps(unknowns: FloatArray, pulses: Pulses) -> FloatArray:
    """How far each pulse's ramp contradicts whether the chair turned: sets x pulses.

    0 where the ramp is below the breakaway speed and the chair stuck, or above and it turned.
    """
    u = unknowns[:, :, None, None]
    requested = _requested(u, pulses)
    above = np.minimum(np.exp(u[:, ACCELERATE]) * pulses.seconds, requested) - u[:, BREAKAWAY]
    return np.maximum(0.0, np.where(pulses.turned, -above, above))[:, :, 0]


def _full(u: FloatArray, pulses: Pulses) -> FloatArray:
    return np.asarray(np.exp(np.where(pulses.deflection > 0, u[:, LEFT], u[:, RIGHT])))


def _requested(u: FloatArray, pulses: Pulses) -> FloatArray:
    """The speed each pulse requests, without sign."""
    band = u[:, DEADBAND]
    share = np.clip((np.abs(pulses.deflection) - band) / (pulses.full - band), 0.0, 1.0)
    return np.asarray(_full(u, pulses) * share)


def _wheels(u: FloatArray, pulses: Pulses, late_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The wheels' distance in the pulse's own direction, and how long they moved between each
    sample and the one before."""
    full, requested, friction = _full(u, pulses), _requested(u, pulses), u[:, FRICTION]
    up, down, lag = np.exp(u[:, ACCELERATE]), np.exp(u[:, BRAKE]), np.exp(u[:, LAG])
    rising = np.minimum(pulses.seconds, requested / up)
    breaks = np.maximum(friction, u[:, BREAKAWAY])
    loose = breaks / up  # when it breaks loose
    zero = pulses.seconds + np.maximum(0.0, up * rising - friction) / down
    less = full / (full - friction)  # full deflection still gives the full speed
    jump, up, down = less * (breaks - friction), less * up, less * down
    ramps = ((up, loose), (-up, rising), (-down, pulses.seconds), (down, zero))

    def at(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        # A ramp turns slope * x**2 / 2 less lag times the rate that it has led to. What is left of
        # the lags, exp(-x / lag), differs by factors only: an exponential takes the longest.
        left = np.exp((pulses.seconds - t) / lag)
        squares, rate = np.zeros_like(t), np.zeros_like(t)
        for slope, begin in ramps:
            x = np.maximum(0.0, t - begin)
            gone = 1.0 - np.minimum(1.0, left * np.exp((begin - pulses.seconds) / lag))
            if begin is loose:
                jumped = jump * gone
                way = jump * x - lag * jumped
            rate += slope * (x - lag * gone)
            squares += 0.5 * slope * x * x
        return way + squares - lag * rate, rate + jumped

    t = pulses.time_s - u[:, DEAD] - late_s
    held = zero + lag * np.log(np.maximum(1.0, at(zero)[1] / _STILL_DPS))
    way, rate = at(np.minimum(t, held))
    moves = pulses.turned & (t < held)
    way, rate = np.where(pulses.turned, way, 0.0), np.where(moves, rate, 0.0)
    step_s = np.diff(pulses.time_s, axis=1, prepend=pulses.time_s[:, :1])
    return way, np.clip(rate / _SLOW_DPS, 0.0, 1.0) * step_s


def _casters(u: FloatArray, wheels: FloatArray, left: BoolArray) -> FloatArray:
    """How far they have swung, as a fraction, in the direction of each pulse."""
    lie = u[:, LIE, :, 0]  # 0: as after turning right, 1: as after turning left; sets x 1
    part = wheels / np.exp(u[:, CASTER_WAY])
    start = np.empty_like(part[:, :, :1])
    for row in range(wheels.shape[1]):
        start[:, row] = np.clip(lie if left[row] else 1.0 - lie, 0.0, 1.0)
        end = np.minimum(1.0, start[:, row] + part[:, row, -1:])
        lie = end if left[row] else 1.0 - end
    now = start + part
    cosine = np.full_like(now, -1.0)  # of those that have swung round
    np.cos(np.pi * now, out=cosine, where=now < 1.0)
    return np.asarray(0.5 * (np.cos(np.pi * start) - cosine))


def angle_deg(numbers: TurnNumbers, deflection: float, pulse_s: float) -> float:
    """How far a pulse turns the chair until it rests, degrees, without sign."""
    full = numbers.left_dps if deflection > 0 else numbers.right_dps
    band = numbers.deadband
    speed = full * min(1.0, max(0.0, (abs(deflection) - band) / (1.0 - band)))
    up, down = numbers.accelerate_dps2, numbers.brake_dps2
    rising = min(pulse_s, speed / up)
    peak = up * rising
    if peak <= numbers.breakaway_dps:
        return 0.0
    stood = 0.5 * numbers.breakaway_dps**2 / up
    return peak * (pulse_s - rising) + 0.5 * peak * (rising + peak / down) - stood
