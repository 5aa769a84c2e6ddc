"""Shares of the processor: requests from strangers never delay the chair's own threads.

Python runs one thread at a time. So strangers, and the requests of each role, take turns: a few at
once, and on average no more than a share of one processor. Waiting for the network takes no
turn. Each piece of work is charged the processor time that it used, so the share is kept on a
slow computer and for the most expensive request.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator

from gazechair.base.latest_value import Clock

SHARE = 0.25
BURST_S = 0.05
LONGEST_WAIT_S = 5.0
_MINE = threading.local()  # billed_s: of this thread's processor time, by any Shares


class Crowded(Exception):
    """Raised when no turn became free in time."""


class Shares:
    """Thread-safe."""

    def __init__(
        self,
        at_once: int = 1,
        burst_s: float = BURST_S,
        clock: Clock = time.monotonic,
        spent: Clock = time.thread_time,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """`burst_s` of a processor at once; `spent`: the calling thread's time."""
        self._at_once = at_once
        self._free: dict[str, threading.BoundedSemaphore] = {}
        self._burst_s = burst_s
        self._clock = clock
        self._spent = spent
        self._sleep = sleep
        self._lock = threading.Lock()
        self._owed_s = 0.0  # processor time not yet paid off by elapsed time
        self._last_s = clock()

    @contextlib.contextmanager
    def turn(self, limit_s: float = LONGEST_WAIT_S, kind: str = "") -> Iterator[None]:
        """Work inside the context. Raises Crowded when no turn comes within `limit_s`.

        At once are `at_once` of each `kind`: work that waits, for a disk or the board, holds up
        no other kind. The share is of all kinds together.
        """
        free = self._free.get(kind) or self._of_kind(kind)
        if not free.acquire(timeout=limit_s):
            raise Crowded
        try:
            if self._wait_s() > limit_s:
                raise Crowded
            self.pause(limit_s)
            yield
        finally:
            self.bill()
            free.release()

    def _of_kind(self, kind: str) -> threading.BoundedSemaphore:
        return self._free.setdefault(kind, threading.BoundedSemaphore(self._at_once))

    def bill(self) -> None:
        """Bill the calling thread's processor time since its last bill, or since it began."""
        now_s = self._spent()
        spent_s = now_s - getattr(_MINE, "billed_s", 0.0)
        _MINE.billed_s = now_s
        with self._lock:
            self._owed_s = self._still_owed() + spent_s

    def pause(self, most_s: float) -> None:
        """Wait until little enough is owed, at most `most_s`."""
        wait_s = min(self._wait_s(), most_s)
        if wait_s > 0:
            self._sleep(wait_s)

    def _wait_s(self) -> float:
        with self._lock:
            self._owed_s = self._still_owed()
            return (self._owed_s - self._burst_s) / SHARE

    def _still_owed(self) -> float:
        now_s = self._clock()
        paid_s = max(0.0, now_s - self._last_s) * SHARE
        self._last_s = now_s
        return max(0.0, self._owed_s - paid_s)


def write_off() -> None:
    """Do not charge the calling thread's processor time since its last charge to any client."""
    _MINE.billed_s = time.thread_time()
