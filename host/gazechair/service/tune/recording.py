"""One tuning pulse as the board's telemetry showed it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
    """The board's clock, counted on over its wraps."""
    heading_deg: float
    """Counted on over full turns, left positive."""
    turn_permille: int
    """The turn output."""
    override: int
    """Why the board overrules the command (codes), 0: it does not."""


@dataclass(frozen=True)
class Recording:
    """A pulse and the chair's answer, until it rested again."""

    deflection: float
    """What the wiper really gave, -1..1, left positive."""
    pulse_s: float
    time_s: Floats
    """Of the samples, since the wiper moved."""
    heading_deg: Floats
    """Since then, degrees, left positive."""
    noise_deg: float
    """Standard deviation of the heading at rest before it."""
    full_deflection: float = 1.0
    """What the wiper gives to that side at most, without sign: full speed is found for that."""

    @property
    def turned_deg(self) -> float:
        """In all, left positive."""
        return float(self.heading_deg[-1])
