"""One tuning pulse as recorded from the board's telemetry."""

from __future__ import annotations

from dataclasses import dataclass

from gazechair.base.arrays import FloatArray


@dataclass(frozen=True)
class Pulse:
    """The pulse requested from the board."""

    turn_permille: int
    """Deflection, left positive, -1000..1000."""
    pulse_ms: int
    """It ends by itself after this."""


@dataclass(frozen=True)
class Sample:
    """The content of one STATE frame."""

    ms: int
    """The board's clock, unwrapped."""
    heading_deg: float
    """Unwrapped over full turns, left positive."""
    turn_permille: int
    """The turn output."""
    override: int
    """Why the board overrules the command (codes), 0: it does not."""


@dataclass(frozen=True)
class Recording:
    """A pulse and the chair's response, until it rested again."""

    deflection: float
    """The wiper's actual deflection, -1..1, left positive."""
    pulse_s: float
    time_s: FloatArray
    """Of the samples, since the wiper moved."""
    heading_deg: FloatArray
    """Since then, degrees, left positive."""
    noise_deg: float
    """Standard deviation of the heading at rest before it."""
    full_deflection: float = 1.0
    """The largest deflection to that side, without sign: it gives the full speed."""

    @property
    def turned_deg(self) -> float:
        """In all, left positive."""
        return float(self.heading_deg[-1])
