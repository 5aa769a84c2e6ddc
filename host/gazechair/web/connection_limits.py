"""Limits for open connections: which one closes when there are too many or they take too long.

A connection is new until it has become a socket of a paired device. A new one is always accepted:
when too many are new, the oldest new one closes, from the same address first. So strangers cannot
exhaust the connection limit before a driver connects. A request has 10 s, so that idle
connections, half an encryption handshake or an endless header affect no other connection.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import Any

from gazechair.base.latest_value import Clock
from gazechair.web.connection import cut

MOST_NEW = 48
MOST_NEW_OF_ADDRESS = 24
LONGEST_NEW_S = 10.0


@dataclass(eq=False)
class OpenConnection:
    """One open connection."""

    raw: Any
    """Its network socket."""
    address: str
    since_s: float
    settled: str = ""
    """The socket and device that it has become: "control 3fa2b1"; "": still new."""
    evicted: bool = False

    @property
    def is_new(self) -> bool:
        """It has a deadline, and counts as new: neither settled nor about to close."""
        return not self.settled and not self.evicted


class OpenConnections:
    """Thread-safe."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._connections: dict[Any, OpenConnection] = {}

    def admit(self, raw: Any, address: str) -> list[OpenConnection]:
        """Add a new connection; returns those that must close for it."""
        connection = OpenConnection(raw, address, self._clock())
        with self._lock:
            new = [one for one in self._connections.values() if one.is_new]
            same = [one for one in new if one.address == address]
            gone = []
            if len(same) >= MOST_NEW_OF_ADDRESS:
                gone = same[:1]
            elif len(new) >= MOST_NEW:
                gone = new[:1]
            for old in gone:
                old.evicted = True
                cut(old)
            self._connections[raw] = connection
        return gone

    def leave(self, raw: Any) -> None:
        """The connection is closed."""
        with self._lock:
            self._connections.pop(raw, None)

    def settle(self, raw: Any, what: str) -> None:
        """The connection has become `what`, a paired device's socket: no deadline any more."""
        with self._lock:
            connection = self._connections.get(raw)
            if connection is not None:
                connection.settled = what

    def cut_settled(self, what: str) -> None:
        """Break every connection that has become `what`."""
        with self._lock:
            for connection in self._connections.values():
                if connection.settled == what:
                    cut(connection)

    def cut_overdue(self) -> None:
        """Break connections that have been new for too long. Call it often."""
        with self._lock:
            limit_s = self._clock() - LONGEST_NEW_S
            for connection in self._connections.values():
                if connection.is_new and connection.since_s < limit_s:
                    connection.evicted = True
                    cut(connection)

    @property
    def new(self) -> int:
        """How many connections are new."""
        with self._lock:
            return sum(one.is_new for one in self._connections.values())
