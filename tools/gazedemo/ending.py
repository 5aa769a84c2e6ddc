"""Handles the signals that end a program: never lost, never in the middle of a critical step."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager

_ENDINGS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_AGAIN_S = 0.2
_AT_ONCE_S = 0.1  # a terminal and a parent may each send one: the second arrives while we end

_raised_at = 0.0


def listen() -> None:
    """From now on each of these signals raises KeyboardInterrupt in the main thread.

    Again every 200 ms until `enough`: Python drops an exception that falls into a callback.
    """
    for number in (*_ENDINGS, signal.SIGALRM):
        signal.signal(number, _interrupt)


def enough() -> None:
    """The program is ending: ignore further signals."""
    signal.setitimer(signal.ITIMER_REAL, 0)
    for number in (*_ENDINGS, signal.SIGALRM):
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def later() -> Iterator[None]:
    """A context in which signals are delayed; they are delivered after it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (*_ENDINGS, signal.SIGALRM))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _interrupt(*_: object) -> None:
    global _raised_at
    signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
    before, _raised_at = _raised_at, time.monotonic()
    if _raised_at - before > _AT_ONCE_S:
        raise KeyboardInterrupt
