"""Nobody arms while settings of the board are stored: armed, it would refuse the rest of them.

What is only set would stay in force, and perhaps in the flash, without anybody knowing.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Storing:
    """Thread-safe. Nothing that stops the chair asks here."""

    def __init__(self, drives: Callable[[], bool]) -> None:
        """`drives`: True while somebody drives, or has asked to."""
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
