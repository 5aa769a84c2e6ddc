"""Warnings that strangers cause: said, but a flood of them does not fill the disk."""

from __future__ import annotations

import logging
import threading
import time

from gazechair.rate_limit import RateLimit
from gazechair.slots import Clock

_PER_S = 0.2
_BURST = 20


class Complaints:
    """A logger's warnings: 20 at once, then one in 5 s, which tells how many were left out."""

    def __init__(self, log: logging.Logger, clock: Clock = time.monotonic) -> None:
        self._log = log
        self._clock = clock
        self._lock = threading.Lock()
        self._limit = RateLimit(_PER_S, _BURST)
        self._left_out = 0

    def warn(self, text: str, *arguments: object) -> None:
        """As logging.Logger.warning."""
        with self._lock:
            if not self._limit.allow(self._clock()):
                self._left_out += 1
                return
            left_out, self._left_out = self._left_out, 0
        more = f" (and {left_out} more before)" if left_out else ""
        self._log.warning(text + more, *arguments)
