"""How a BNO055 measures a turn: 100 Hz, late, noisy, with scale error and drift, in 1/16 degree."""

from __future__ import annotations

import random
from collections import deque
from dataclasses import dataclass

SAMPLE_S = 0.010


@dataclass(frozen=True)
class ImuErrors:
    """Errors of one sensor: data sheet and estimates; `ImuErrors()` has only its latency."""

    scale: float = 1.0  # of rate and heading
    drift_deg_s: float = 0.0  # of the heading
    noise_deg_s: float = 0.0  # standard deviation of a rate sample
    latency_s: float = 0.015  # of the fusion and the gyroscope's filter: what is shown is that old

    @classmethod
    def drawn(cls, source: random.Random) -> ImuErrors:
        """One sensor at random: scale within 0.5 %, drift within 0.3 deg/min, 10..20 ms late."""
        return cls(
            scale=1.0 + source.uniform(-0.005, 0.005),
            drift_deg_s=source.uniform(-0.005, 0.005),
            noise_deg_s=0.1,
            latency_s=source.uniform(0.010, 0.020),
        )


class Imu:
    """The sensor's heading and rate, counter-clockwise positive; the heading starts at zero."""

    def __init__(self, errors: ImuErrors, seed: int = 1) -> None:
        self.errors = errors
        self._random = random.Random(seed)
        self.restart()

    def restart(self) -> None:
        """The fusion restarts: heading zero, the next sample in 10 ms."""
        self.heading_deg = 0.0
        """Shown heading, not wrapped."""
        self.rate_deg_s = 0.0
        """Shown rate."""
        self._now_s = 0.0
        self._sample_in_s = SAMPLE_S
        self._true_deg = 0.0
        self._offset_deg = 0.0
        self._past: deque[tuple[float, float, float]] = deque(((0.0, 0.0, 0.0),))

    @property
    def heading_q4(self) -> int:
        """Shown heading in 1/16 degree, not wrapped."""
        return round(self.heading_deg * 16.0)

    @property
    def rate_q4(self) -> int:
        """Shown rate in 1/16 degree/s."""
        return round(self.rate_deg_s * 16.0)

    def jump(self, jump_deg: float) -> None:
        """Fault: from the next sample on the heading is off by that much."""
        self._offset_deg += jump_deg

    def step(self, dt_s: float, yaw_rate_deg_s: float) -> bool:
        """Advance by `dt_s` (at most a sample period) at that rate; True when a sample is new."""
        errors = self.errors
        self._now_s += dt_s
        rate = yaw_rate_deg_s * errors.scale
        self._true_deg += (rate + errors.drift_deg_s) * dt_s
        past = self._past
        past.append((self._now_s, self._true_deg, rate))
        self._sample_in_s -= dt_s
        if self._sample_in_s > 1e-9:
            return False
        self._sample_in_s += SAMPLE_S
        shown_s = self._now_s - errors.latency_s
        while len(past) > 1 and past[1][0] <= shown_s + 1e-9:
            past.popleft()
        (at_s, heading, rate) = past[0]
        self.heading_deg = heading + rate * max(0.0, shown_s - at_s) + self._offset_deg
        self.rate_deg_s = rate
        if errors.noise_deg_s:
            self.rate_deg_s += self._random.gauss(0.0, errors.noise_deg_s)
        return True
