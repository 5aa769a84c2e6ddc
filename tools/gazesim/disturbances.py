"""Effects of floor, load and casters on the chair's motion; the default has none."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace

from gazesim.chair_axis import Axis

_WANDER_S = 0.1
_WANDER_KEEP = 0.95
_WANDER_ADD = 0.3


@dataclass(frozen=True)
class Disturbances:
    """All of them zero (factors 1) by default: `Disturbances()` is the undisturbed chair."""

    gain: float = 1.0  # factor on the speeds: battery, tyres, floor
    load: float = 1.0  # factor on the inertia, which the lag follows
    veer: float = 0.0  # standard deviation of a slow random share of the speeds: uneven floor
    slope_deg_s: float = 0.0  # the most a sloping floor turns the moving chair towards downhill
    downhill_deg: float = 0.0  # heading of downhill
    caster_deg: float = 0.0  # yaw while the casters swing round, negative against a turn
    caster_s: float = 0.5  # how long they take at full speed

    def __post_init__(self) -> None:
        if min(self.gain, self.load, self.caster_s) <= 0.0 or self.veer < 0.0:
            raise ValueError("gain, load and caster_s must be above 0, veer 0 or more")

    def axis(self, axis: Axis) -> Axis:
        """That axis under this load and on this floor."""
        return replace(
            axis,
            positive=axis.positive * self.gain,
            negative=axis.negative * self.gain,
            lag_s=axis.lag_s * self.load,
        )

    @classmethod
    def drawn(cls, source: random.Random) -> Disturbances:
        """A floor, a load and casters at random.

        Ranges: gain +/- 30 %, caster 5..15 deg over 0.3..0.8 s (estimates for mid-wheel chairs);
        load 0.8..1.3, veer up to 4 %, slope up to 1.5 deg/s (own estimates).
        """
        return cls(
            gain=source.uniform(0.7, 1.3),
            load=source.uniform(0.8, 1.3),
            veer=source.uniform(0.0, 0.04),
            slope_deg_s=source.uniform(0.0, 1.5),
            downhill_deg=source.uniform(-180.0, 180.0),
            caster_deg=source.choice((-1.0, 1.0)) * source.uniform(5.0, 15.0),
            caster_s=source.uniform(0.3, 0.8),
        )


class Floor:
    """The disturbances in motion: what they add to the speeds, drawn from a seed."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self.veer = [0.0, 0.0]
        """Share of the linear and of the turn speed."""
        self._wander_in_s = 0.0
        # The casters' position, for driving and for turning: 1 as after forward or left.
        self._lie = [self._random.choice((-1.0, 1.0)), self._random.choice((-1.0, 1.0))]

    def wander(self, dt_s: float, spread: float) -> None:
        """Renew `veer`: a random walk that tends back to zero, ten steps a second."""
        self._wander_in_s -= dt_s
        if self._wander_in_s <= 1e-9:
            self._wander_in_s += _WANDER_S
            for axis in (0, 1):
                step = self._random.gauss(0.0, spread)
                self.veer[axis] = _WANDER_KEEP * self.veer[axis] + _WANDER_ADD * step

    def casters_deg_s(
        self, numbers: Disturbances, dt_s: float, linear_share: float, turn_share: float
    ) -> float:
        """The yaw rate the swinging casters add; shares are the speeds, -1..1 of the full ones.

        They swing over the wheels' distance, so a standing chair keeps their position, and
        going back swings them back: all reversals together never add more than `caster_deg`.
        """
        rate = 0.0
        for axis, share in enumerate((linear_share, turn_share)):
            old = self._lie[axis]
            if share and old * share < abs(share):
                new = max(-1.0, min(1.0, old + 2.0 * share * dt_s / numbers.caster_s))
                self._lie[axis] = new
                swung = math.sin(0.5 * math.pi * new) - math.sin(0.5 * math.pi * old)
                rate += 0.5 * numbers.caster_deg * swung / dt_s
        return rate
