"""How a chair turns, in the numbers the board stores per speed profile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gazelink.settings_table import (
    NO_CASTERS_Q4_DEG,
    PROFILES,
    TABLE,
    index_of,
    profile_row,
)


@dataclass(frozen=True)
class TurnNumbers:
    """A joystick's deflection passes the deadband, waits for the dead time, is followed by the
    ramp of the chair's own controller (accelerate, brake) and by the lag of chair and wheels."""

    left_dps: float
    """Turn rate at full deflection, degrees/s."""
    right_dps: float
    deadband: float
    """Fraction of the deflection without effect, 0..1."""
    dead_time_s: float
    """From wiper to heading as the board receives it, including the sensor's delay."""
    lag_s: float
    accelerate_dps2: float
    brake_dps2: float
    breakaway_dps: float
    """A ramp below this does not set a standing chair in motion."""
    caster_deg: float = 0.0
    """How much further the chair turns after a reversal, while the casters swing round."""
    caster_way_deg: float = 25.0
    """How far the wheels turn meanwhile."""

    @classmethod
    def of(cls, profile: str, values: Sequence[int]) -> TurnNumbers:
        """The rows of `profile` among the settings' `values` (in the order of the table)."""

        def row(name: str) -> int:
            return int(values[index_of(profile_row(PROFILES.index(profile), name))])

        return cls(
            row("left_q4_dps") / 16,
            row("right_q4_dps") / 16,
            row("deadband_permille") / 1000,
            row("dead_time_ms") / 1000,
            row("lag_ms") / 1000,
            float(row("accelerate_dps2")),
            float(row("brake_dps2")),
            row("breakaway_q4_dps") / 16,
            (row("caster_q4_deg") - NO_CASTERS_Q4_DEG) / 16,
            row("caster_way_q4_deg") / 16,
        )

    @classmethod
    def default(cls, profile: str) -> TurnNumbers:
        """The defaults of `profile` until it is tuned."""
        return cls.of(profile, [default for _, default, _, _ in TABLE])

    def rows(self, profile: str) -> dict[str, int]:
        """{setting: value} to store for `profile`, `tuned` among them."""
        found = {
            "left_q4_dps": self.left_dps * 16,
            "right_q4_dps": self.right_dps * 16,
            "deadband_permille": self.deadband * 1000,
            "dead_time_ms": self.dead_time_s * 1000,
            "lag_ms": self.lag_s * 1000,
            "accelerate_dps2": self.accelerate_dps2,
            "brake_dps2": self.brake_dps2,
            "breakaway_q4_dps": max(0.0, self.breakaway_dps) * 16,
            "caster_q4_deg": NO_CASTERS_Q4_DEG + self.caster_deg * 16,
            "caster_way_q4_deg": min(124.0, max(6.0, self.caster_way_deg)) * 16,
            "tuned": 1,
        }
        row = PROFILES.index(profile)
        return {profile_row(row, name): round(value) for name, value in found.items()}


def scaled(numbers: TurnNumbers, factor: float) -> TurnNumbers:
    """The same chair turning `factor` times as fast."""
    return replace(
        numbers, left_dps=numbers.left_dps * factor, right_dps=numbers.right_dps * factor
    )
