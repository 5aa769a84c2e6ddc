"""A rate limit with injected time."""

from __future__ import annotations


class RateLimit:
    """A bucket of `burst` allowances, refilled at `per_s` a second."""

    def __init__(self, per_s: float, burst: float) -> None:
        self._per_s = per_s
        self._burst = burst
        self._level = burst
        self._last_s: float | None = None

    def allow(self, now_s: float, cost: float = 1.0) -> bool:
        """Take `cost` allowances; False, and none taken, when there are fewer left."""
        if self._last_s is not None:
            gained = max(0.0, now_s - self._last_s) * self._per_s
            self._level = min(self._burst, self._level + gained)
        self._last_s = now_s
        if self._level < cost:
            return False
        self._level -= cost
        return True
