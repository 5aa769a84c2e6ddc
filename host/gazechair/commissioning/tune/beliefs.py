"""Priors for a chair before its pulses are seen: means, spreads and limits of its unknowns.

The unknowns are the columns of model.py; sizes and times as logarithms. After those of the chair
follow those of the pulses: the fraction by which each turns the wheels further than the others (an
uneven floor), then how much later than recorded each began.
"""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.commissioning.tune import model
from gazechair.commissioning.tune.descent import Bounds
from gazechair.commissioning.tune.numbers import TurnNumbers

# column: (spread around the profile's prior, lowest, highest)
_ROWS = {
    model.LEFT: (0.25, 1.0, 5.5),
    model.RIGHT: (0.25, 1.0, 5.5),
    model.DEADBAND: (0.05, 0.0, 0.3),
    model.DEAD: (0.06, 0.02, 0.4),
    model.LAG: (0.5, -4.0, -0.2),
    model.ACCELERATE: (0.5, 3.0, 6.2),
    model.BRAKE: (0.35, 3.0, 6.2),
    model.BREAKAWAY: (6.0, 0.0, 29.0),
    model.CASTER: (6.0, -20.0, 20.0),
    model.CASTER_WAY: (0.6, 0.5, 5.0),
    model.LIE: (0.5, 0.0, 1.0),
    model.SLOPE: (0.7, -4.0, 4.0),
    model.BEND: (0.7, -4.0, 4.0),
    model.FRICTION: (0.3, 0.0, 4.0),
}
_FRICTION_DPS = 0.4  # of the chair whose turns were published
_PULSE = (0.03, -1.0, 1.0)
_LATE_S = (0.0015, -0.006, 0.006)  # the start is unknown within 5 ms
_WAY_S = 0.5  # casters swing round in that time at full speed
_LOOSE_SHARE = 0.8  # of the full speed at most is needed to break loose: it turned


def bounds(pulses: int) -> Bounds:
    """Bounds of the unknowns of a chair and this many pulses."""
    chair = [_ROWS[column] for column in range(model.UNKNOWNS)]
    rows = np.array(chair + [_PULSE] * pulses + [_LATE_S] * pulses)
    return Bounds(low=rows[:, 1], high=rows[:, 2], size=rows[:, 0])


def unknowns(n: TurnNumbers, pulses: int) -> FloatArray:
    """The prior means for such a chair; zero for casters, slope and pulses."""
    left, right, lag, accelerate, brake = np.log(
        [n.left_dps, n.right_dps, n.lag_s, n.accelerate_dps2, n.brake_dps2]
    )
    out = np.zeros(model.UNKNOWNS + 2 * pulses)
    out[:8] = left, right, n.deadband, n.dead_time_s, lag, accelerate, brake, n.breakaway_dps
    out[model.CASTER_WAY] = np.log(_WAY_S * 0.5 * (n.left_dps + n.right_dps))
    out[model.LIE] = 0.5
    out[model.FRICTION] = _FRICTION_DPS
    return out


def numbers(u: FloatArray) -> TurnNumbers:
    """The chair that these unknowns describe."""
    left, right, lag, accelerate, brake = np.exp(
        u[[model.LEFT, model.RIGHT, model.LAG, model.ACCELERATE, model.BRAKE]]
    ).tolist()
    return TurnNumbers(
        left,
        right,
        float(u[model.DEADBAND]),
        float(u[model.DEAD]),
        lag,
        accelerate,
        brake,
        min(float(u[model.BREAKAWAY]), _LOOSE_SHARE * min(left, right)),
        float(u[model.CASTER]),
        float(np.exp(u[model.CASTER_WAY])),
    )
