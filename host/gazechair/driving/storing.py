"""Prevents arming while settings of the board are stored: an armed board refuses the rest.

Values that are set but not stored would stay in force, and perhaps in the flash, unnoticed.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Storing:
    """Thread-safe. Nothing that stops the chair waits for it."""

    def __init__(self, drives: Callable[[], bool]) -> None:
        """`drives`: True while somebody drives, or has requested to."""
        self._drives = drives
        self._lock = threading.Lock()
        self._stores = 0

    @contextmanager
    def store(self) -> Iterator[bool]:
        """Store within it; False: somebody drives, or is about to."""
        with self._lock:
            free = not self._drives()
            self._stores += free
        try:
            yield free
        finally:
            with self._lock:
                self._stores -= free

    @contextmanager
    def arm(self) -> Iterator[bool]:
        """Ask for the chair, or change its cap, within it; False: settings are being stored."""
        with self._lock:
            yield self._stores == 0
