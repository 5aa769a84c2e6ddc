"""What every WebSocket here gets: a send lock, a bounded inbox, no nameless thread."""

from __future__ import annotations

import contextlib
import socket
import threading
from typing import Any

from simple_websocket import ConnectionClosed
from wsproto.utilities import LocalProtocolError

_MAX_WAITING = 256
_SEND_BUFFER = 32_768  # 4 MB by default: seconds of stale state before a slow reader
_PEER_GONE_MS = 3_000

# What sending, receiving or closing raises once the other side, or we, closed.
GONE = (ConnectionClosed, LocalProtocolError, OSError)

# RFC 6455 section 7.4.1, and the IANA registry for the last.
CLOSE_GOING_AWAY = 1001
CLOSE_UNSUPPORTED = 1003
CLOSE_POLICY = 1008
CLOSE_TRY_LATER = 1013
CLOSE_REVOKED = 4001  # our own; see docs/developing-pages.md


def tune(connection: socket.socket) -> None:
    """Small messages at once, little queued, a dead peer noticed in 3 s."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _PEER_GONE_MS)


class ReaderThread(threading.Thread):
    """simple-websocket's receiving thread, held back until `prepare` has readied the socket."""

    def __init__(self, target: Any) -> None:
        super().__init__(target=target, name="web-socket-read", daemon=True)

    def start(self) -> None:
        """Does nothing: the library calls it before anyone could prepare the socket."""

    def release(self) -> None:
        """Start for real."""
        super().start()


def prepare(ws: Any) -> None:
    """Make a fresh simple-websocket connection safe to send on, then start reading."""
    ws.sock = _Whole(ws.sock)
    ws.input_buffer = _Inbox()
    ws.thread.release()


def hang_up(ws: Any) -> None:
    """Cut the connection now: whoever blocks on it, sending or receiving, wakes up."""
    with contextlib.suppress(OSError):
        ws.sock.shutdown(socket.SHUT_RDWR)


class _Inbox(list[Any]):
    """Messages not yet handled. A client that overfills it is cut off, which stops it."""

    def append(self, item: Any) -> None:
        if len(self) >= _MAX_WAITING:
            raise ConnectionAbortedError("messages come faster than they are handled")
        super().append(item)


class _Whole:
    """A socket whose sends are whole and one at a time: the library answers pings by itself."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection = connection
        self._lock = threading.Lock()

    def send(self, data: bytes) -> int:
        with self._lock:
            self._connection.sendall(data)
        return len(data)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._connection, name)
