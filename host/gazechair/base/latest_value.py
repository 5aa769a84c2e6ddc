"""A latest-value slot: keeps only the newest value and its birth time; nothing is ever queued."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")
Clock = Callable[[], float]


@dataclass(frozen=True)
class Entry(Generic[T]):
    """One value as it lay in the slot."""

    value: T
    born_s: float
    """Monotonic time of the value's birth (acquisition), seconds."""
    version: int
    """1 for the first value put, then one more each time."""


class Latest(Generic[T]):
    """Keeps the newest value put by any thread; readers may poll it or wait for a newer one."""

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._changed = threading.Condition()
        self._entry: Entry[T] | None = None
        self._version = 0

    def put(self, value: T, born_s: float | None = None) -> int:
        """Replace the value, born at monotonic `born_s` (default: now); returns its version."""
        with self._changed:
            self._version += 1
            born = self._clock() if born_s is None else born_s
            self._entry = Entry(value, born, self._version)
            self._changed.notify_all()
            return self._version

    def clear(self) -> None:
        """Empty the slot, as before the first put; versions continue to count."""
        with self._changed:
            self._entry = None

    def entry(self) -> Entry[T] | None:
        """The newest value with its birth time and version, or None when the slot is empty."""
        return self._entry

    def get(self) -> T | None:
        """The newest value, or None when the slot is empty."""
        entry = self._entry
        return None if entry is None else entry.value

    def age_s(self) -> float | None:
        """Seconds since the newest value's birth, or None when the slot is empty."""
        entry = self._entry
        return None if entry is None else self._clock() - entry.born_s

    def wait(self, timeout_s: float, after: int = 0) -> Entry[T] | None:
        """Wait for a value with a version above `after`; None when none came within `timeout_s`."""
        with self._changed:
            self._changed.wait_for(
                lambda: self._entry is not None and self._entry.version > after, timeout_s
            )
            entry = self._entry
            return entry if entry is not None and entry.version > after else None
