"""The first prototype's own turn controller, as published: PID on the heading error, to counts.

Published: the gains, outputs 85..254, P/PI/PD/PID by gains of zero, the cut-off of 2 degrees. Not
published: how often it ran and the time unit of Ki and Kd; a `Reading` is one guess at both.
"""

from __future__ import annotations

from dataclasses import dataclass

NEUTRAL, LOWEST, HIGHEST = 170, 85, 254
SAMPLE, SECOND, MILLISECOND = "sample", "second", "ms"


@dataclass(frozen=True)
class Reading:
    """How the published gains may have been meant."""

    name: str
    rate_hz: int
    """Controller runs a second: 100 (each new heading) or 1000."""
    ki_unit: str
    """The error is summed per SAMPLE, or multiplied by the step in SECONDs or MILLISECONDs."""
    kd_unit: str
    """Likewise for the differences of the error."""

    def ki_factor(self) -> float:
        """What one step adds to the sum, per degree."""
        return {SAMPLE: 1.0, SECOND: 1.0 / self.rate_hz, MILLISECOND: 1e3 / self.rate_hz}[
            self.ki_unit
        ]

    def kd_factor(self) -> float:
        """What a difference between two steps counts, per degree."""
        return {SAMPLE: 1.0, SECOND: float(self.rate_hz), MILLISECOND: 1e-3 * self.rate_hz}[
            self.kd_unit
        ]


READINGS = (
    Reading("per sample, 1000 Hz", 1000, SAMPLE, SAMPLE),
    Reading("per sample, 100 Hz", 100, SAMPLE, SAMPLE),
    Reading("per second", 100, SECOND, SECOND),
    Reading("Ki per sample, Kd per second, 1000 Hz", 1000, SAMPLE, SECOND),
    Reading("Ki per sample, Kd per second, 100 Hz", 100, SAMPLE, SECOND),
)
"""Per millisecond is the same as per sample at 1000 Hz."""
FITTED = READINGS[1]
"""The reading under which the twin was identified: all clues hold, within the priors."""


@dataclass(frozen=True)
class Gains:
    """In counts per degree, and per degree and time unit of the reading."""

    kp: float
    ki: float
    kd: float


PUBLISHED = Gains(6.0, 0.0005, 1.0)


class Prototype:
    """The controller: `update` with the heading gives the turn wiper's count.

    Left positive. Within the cut-off it puts out neutral and the sum stays constant.
    """

    def __init__(
        self, reading: Reading, gains: Gains, setpoint_deg: float, cutoff_deg: float = 0.0
    ) -> None:
        self._kp = gains.kp
        self._ki = gains.ki * reading.ki_factor()
        self._kd = gains.kd * reading.kd_factor()
        self._setpoint_deg = setpoint_deg
        self._cutoff_deg = cutoff_deg
        self._sum = 0.0
        self._last: float | None = None

    def update(self, heading_deg: float) -> int:
        """One run of the controller."""
        error = self._setpoint_deg - heading_deg
        change = 0.0 if self._last is None else error - self._last
        self._last = error
        if -self._cutoff_deg < error < self._cutoff_deg:
            return NEUTRAL
        self._sum += self._ki * error
        out = NEUTRAL + self._kp * error + self._sum + self._kd * change
        return max(LOWEST, min(HIGHEST, round(out)))
