"""A plain connection with the methods that this server uses; TlsSocket is the encrypted one."""

from __future__ import annotations

import contextlib
import select
import socket
import time
from typing import Any, Protocol

Readable = select.POLLIN | select.POLLHUP | select.POLLERR


class Connection(Protocol):
    """One open connection. At most one thread reads; any may send."""

    raw: socket.socket
    """The underlying socket: for OpenConnections, and to cut it."""

    def receive(self, size: int, limit_s: float) -> bytes | None:
        """At most `size` bytes, b"" at the end, None when none came in time. Raises OSError."""
        ...

    def sendall(self, data: bytes) -> None:
        """Send everything. Raises OSError."""
        ...


class PlainConnection:
    """An unencrypted Connection."""

    def __init__(self, raw: socket.socket) -> None:
        self.raw = raw

    def receive(self, size: int, limit_s: float) -> bytes | None:
        """See Connection."""
        return self.raw.recv(size) if readable(self.raw, limit_s) else None

    def sendall(self, data: bytes) -> None:
        """See Connection."""
        self.raw.sendall(data)


class Patience:
    """Longer and longer pauses between pieces, so that bytes sent one by one cost little."""

    _FIRST_S = 0.002
    _LONGEST_S = 0.25

    def __init__(self) -> None:
        self._next_s = 0.0

    def pause(self) -> None:
        """A piece has arrived, and it was not the last; the first pause is zero."""
        if self._next_s > 0:
            time.sleep(self._next_s)
        self._next_s = min(max(self._FIRST_S, 2 * self._next_s), self._LONGEST_S)


def readable(raw: socket.socket, limit_s: float) -> bool:
    """Wait until something, or the end, can be read; False when the time is up."""
    poll = select.poll()
    try:
        poll.register(raw.fileno(), Readable)
    except ValueError:
        raise OSError("the connection is closed") from None
    return bool(poll.poll(max(0.0, limit_s) * 1000))


def cut(connection: Any) -> None:
    """Break a connection by its `raw` socket: threads that send or receive on it wake up."""
    with contextlib.suppress(OSError):
        connection.raw.shutdown(socket.SHUT_RDWR)
