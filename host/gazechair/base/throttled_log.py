"""A throttled log: a flood of refusals or errors does not fill the disk."""

from __future__ import annotations

import logging
import threading
import time

from gazechair.base.latest_value import Clock
from gazechair.base.rate_limit import RateLimit

_PER_S = 0.2
_BURST = 20


class ThrottledLog:
    """A logger's lines: 20 at once, then one in 5 s, with the number of omitted lines."""

    def __init__(self, log: logging.Logger, clock: Clock = time.monotonic) -> None:
        self._log = log
        self._clock = clock
        self._lock = threading.Lock()
        self._limit = RateLimit(_PER_S, _BURST)
        self._left_out = 0

    def warn(self, text: str, *arguments: object, exc_info: bool = False) -> None:
        """As logging.Logger.warning."""
        self._write(logging.WARNING, text, arguments, exc_info)

    def info(self, text: str, *arguments: object) -> None:
        """As logging.Logger.info."""
        self._write(logging.INFO, text, arguments, False)

    def thread_ended(self, args: threading.ExceptHookArgs) -> None:
        """As threading.excepthook: a thread ended by an error, with its traceback."""
        thread = "?" if args.thread is None else args.thread.name
        error = args.exc_value
        self._write(logging.ERROR, "thread %s ended by %r", (thread, error), error or False)

    def _write(
        self, level: int, text: str, arguments: tuple[object, ...], exc_info: bool | BaseException
    ) -> None:
        with self._lock:
            if not self._limit.allow(self._clock()):
                self._left_out += 1
                return
            left_out, self._left_out = self._left_out, 0
        more = f" (and {left_out} more before)" if left_out else ""
        self._log.log(level, text + more, *arguments, exc_info=exc_info)
