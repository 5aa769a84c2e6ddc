"""Limits for open connections: which one closes when there are too many or they take too long.

A connection is new until it has become a socket of a paired device. A new one is always accepted:
when too many are new, the oldest new one closes, from the same address first. So strangers cannot
exhaust the connection limit before a driver connects. A request has 10 s, so that idle
connections, half an encryption handshake or an endless header harm nobody.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from dataclasses import dataclass
from typing import Any

from gazechair.base.latest_value import Clock

MOST_NEW = 48
MOST_NEW_OF_ADDRESS = 24
LONGEST_NEW_S = 10.0


@dataclass(eq=False)
class Place:
    """One open connection."""

    connection: Any
    address: str
    since_s: float
    settled: str = ""
    """The socket and device that it has become: "control 3fa2b1"; "": still new."""
    evicted: bool = False

    def cut(self) -> None:
        """Break the connection; the thread that serves it wakes up and ends."""
        with contextlib.suppress(OSError):
            self.connection.shutdown(socket.SHUT_RDWR)


class Places:
    """Thread-safe."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._places: dict[Any, Place] = {}

    def admit(self, connection: Any, address: str) -> list[Place]:
        """Add a new connection; returns those that must close for it."""
        place = Place(connection, address, self._clock())
        with self._lock:
            new = [p for p in self._places.values() if not p.settled and not p.evicted]
            same = [p for p in new if p.address == address]
            gone = []
            if len(same) >= MOST_NEW_OF_ADDRESS:
                gone = same[:1]
            elif len(new) >= MOST_NEW:
                gone = new[:1]
            for old in gone:
                old.evicted = True
                old.cut()
            self._places[connection] = place
        return gone

    def leave(self, connection: Any) -> None:
        """The connection is closed."""
        with self._lock:
            self._places.pop(connection, None)

    def settle(self, connection: Any, what: str) -> None:
        """The connection has become `what`, a paired device's socket: no deadline any more."""
        with self._lock:
            place = self._places.get(connection)
            if place is not None:
                place.settled = what

    def cut_settled(self, what: str) -> None:
        """Break every connection that has become `what`."""
        with self._lock:
            for place in self._places.values():
                if place.settled == what:
                    place.cut()

    def cut_overdue(self) -> None:
        """Break connections that have been new for too long. Call it often."""
        with self._lock:
            limit_s = self._clock() - LONGEST_NEW_S
            for place in self._places.values():
                if not place.settled and place.since_s < limit_s and not place.evicted:
                    place.evicted = True
                    place.cut()

    @property
    def new(self) -> int:
        """How many connections are new."""
        with self._lock:
            return sum(not p.settled and not p.evicted for p in self._places.values())
