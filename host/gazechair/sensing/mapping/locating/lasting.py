"""How long a condition has held without a break."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Lasting:
    """A condition that counts once it has held for `least_s`."""

    least_s: float
    since_s: float | None = None
    """When it began to hold; None: it does not."""

    def holds(self, time_s: float) -> bool:
        """Note that the condition holds now; whether it has for long enough."""
        if self.since_s is None:
            self.since_s = time_s
        return time_s - self.since_s >= self.least_s

    def end(self) -> None:
        """Note that the condition does not hold, or that its time begins anew."""
        self.since_s = None
