"""The server's side of a WebSocket (RFC 6455): whole messages, one reader, all of it bounded.

There are no extensions. Whatever arrives counts, pings and empty fragments and single bytes too:
who sends more than a page ever does is cut off, which stops what it commanded.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import hashlib
import socket
import struct
import threading
import time
from collections.abc import Mapping
from typing import Any

from gazechair.rate_limit import RateLimit
from gazechair.slots import Clock
from gazechair.web.connection import Connection, cut

MOST_MESSAGE = 1024
"""Above this a socket is closed; a control message above 256 bytes is refused in words first."""
ARRIVALS_PER_S = 1000
"""Of one device's sockets together: frames and reads of the connection."""
_COST_OF_OPENING = 50
_PONGS_PER_S = 10
_READ_SIZE = 4096
_SEND_BUFFER = 32_768  # 4 MB by default: seconds of stale state before a slow reader
_RECEIVE_BUFFER = 32_768  # what a flood may pile up before it is cut
_PEER_GONE_MS = 3_000
_MAGIC = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"  # RFC 6455 section 1.3
_KEY_BYTES = 16

# RFC 6455 section 7.4.1, and the IANA registry for the last of them.
CLOSE_NORMAL = 1000
CLOSE_GOING_AWAY = 1001
CLOSE_PROTOCOL = 1002
CLOSE_UNSUPPORTED = 1003
CLOSE_NOT_TEXT = 1007
CLOSE_POLICY = 1008
CLOSE_TOO_BIG = 1009
CLOSE_TRY_LATER = 1013
CLOSE_REVOKED = 4001  # our own; see docs/developing-pages.md

_MORE, _TEXT, _BINARY, _CLOSE, _PING, _PONG = 0, 1, 2, 8, 9, 10
_LONGEST_CONTROL = 125


class Ended(ConnectionError):
    """The socket has ended; the text says why."""


class BadHandshake(Exception):
    """A request that becomes no WebSocket: one plain line."""


def tune(connection: socket.socket) -> None:
    """Small messages at once, little queued, a dead peer noticed in 3 s."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _PEER_GONE_MS)


def handshake(environ: Mapping[str, Any]) -> bytes:
    """The answer that makes a request a WebSocket. Raises BadHandshake."""
    connection = str(environ.get("HTTP_CONNECTION", "")).lower()
    key = str(environ.get("HTTP_SEC_WEBSOCKET_KEY", ""))
    if "upgrade" not in connection or str(environ.get("HTTP_UPGRADE", "")).lower() != "websocket":
        raise BadHandshake("this address is a WebSocket's")
    if environ.get("REQUEST_METHOD") != "GET" or environ.get("SERVER_PROTOCOL") != "HTTP/1.1":
        raise BadHandshake("a WebSocket begins with GET of HTTP/1.1")
    if environ.get("HTTP_SEC_WEBSOCKET_VERSION") != "13":
        raise BadHandshake("use version 13 of the WebSocket protocol")
    try:
        good = len(base64.b64decode(key, validate=True)) == _KEY_BYTES
    except (binascii.Error, ValueError):
        good = False
    if not good:
        raise BadHandshake("Sec-WebSocket-Key must be 16 bytes in base64")
    proof = base64.b64encode(hashlib.sha1(key.encode() + _MAGIC).digest())
    head = b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    return head + b"Sec-WebSocket-Accept: " + proof + b"\r\n\r\n"


class Arrivals:
    """What one device may send on all its sockets, those that it opens again too. Thread-safe."""

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._limit = RateLimit(ARRIVALS_PER_S, ARRIVALS_PER_S)

    def allow(self) -> bool:
        """Something has arrived; False when it is too much."""
        with self._lock:
            return self._limit.allow(self._clock())

    def allow_opening(self) -> bool:
        """A socket is to be opened; False when that is too much."""
        with self._lock:
            return self._limit.allow(self._clock(), _COST_OF_OPENING)


class WebSocket:
    """One socket: one thread receives; any may send, close or hang up."""

    def __init__(
        self,
        connection: Connection,
        arrivals: Arrivals,
        early: bytes = b"",
        clock: Clock = time.monotonic,
    ) -> None:
        """`arrivals`: its device's; `early`: what came after the handshake's request already."""
        self._connection = connection
        self._clock = clock
        self._unread = bytearray(early)
        self._parts = bytearray()
        self._kind = 0  # of the message whose parts are coming, 0: none is
        self._arrivals = arrivals
        self._pongs = RateLimit(_PONGS_PER_S, _PONGS_PER_S)
        self._sending = threading.Lock()
        self._ended = ""

    def receive(self, limit_s: float) -> str | bytes | None:
        """The next message, None when none came within `limit_s`. Raises OSError: it has ended."""
        end_s = self._clock() + limit_s
        while True:
            if self._ended:
                raise Ended(self._ended)
            frame = self._frame()
            if frame is not None:
                message = self._take(*frame)
                if message is not None:
                    return message
                if self._clock() > end_s:
                    return None
                continue
            part = self._connection.receive(_READ_SIZE, end_s - self._clock())
            if part is None:
                return None
            if not part:
                raise Ended("its connection ended")
            self._count()
            self._unread += part

    def send(self, data: str | bytes) -> None:
        """Send a message whole, after what another thread is sending. Raises OSError."""
        kind = _BINARY if isinstance(data, bytes) else _TEXT
        self._send(kind, data if isinstance(data, bytes) else data.encode())

    def close(self, code: int = CLOSE_NORMAL, why: str = "") -> None:
        """Say why, and end. Raises OSError when it cannot be said any more."""
        try:
            self._send(_CLOSE, struct.pack(">H", code) + why.encode()[: _LONGEST_CONTROL - 2])
        finally:
            self._ended = self._ended or why or "closed"

    def hang_up(self) -> None:
        """Cut the connection now: whoever blocks on it, sending or receiving, wakes up."""
        cut(self._connection)

    def _send(self, kind: int, data: bytes) -> None:
        length = len(data)
        if length < 126:
            head = struct.pack(">BB", 0x80 | kind, length)
        elif length < 1 << 16:
            head = struct.pack(">BBH", 0x80 | kind, 126, length)
        else:
            head = struct.pack(">BBQ", 0x80 | kind, 127, length)
        with self._sending:
            if self._ended:
                raise Ended(self._ended)
            self._connection.sendall(head + data)

    def _fail(self, code: int, why: str) -> Ended:
        with contextlib.suppress(OSError):
            self.close(code, why)
        return Ended(why)

    def _count(self) -> None:
        if not self._arrivals.allow():
            raise self._fail(CLOSE_POLICY, "far too many messages")

    def _frame(self) -> tuple[bool, int, bytes] | None:
        # (last of its message, kind, content) of the first whole frame that has come.
        unread = self._unread
        if len(unread) < 2:
            return None
        first, second = unread[0], unread[1]
        kind, length, begin = first & 15, second & 127, 2
        if first & 0x70 or not second & 0x80 or kind not in (0, 1, 2, 8, 9, 10):
            raise self._fail(CLOSE_PROTOCOL, "no frame of RFC 6455")
        if kind >= _CLOSE and (length > _LONGEST_CONTROL or not first & 0x80):
            raise self._fail(CLOSE_PROTOCOL, "a control frame is short and whole")
        if length > _LONGEST_CONTROL:
            begin = 4 if length == 126 else 10
            if len(unread) < begin:
                return None
            length = int.from_bytes(unread[2:begin], "big")
        if length + (len(self._parts) if kind < _CLOSE else 0) > MOST_MESSAGE:
            raise self._fail(CLOSE_TOO_BIG, f"a message has at most {MOST_MESSAGE} bytes")
        end = begin + 4 + length
        if len(unread) < end:
            return None
        mask = bytes(unread[begin : begin + 4])
        content = _unmasked(bytes(unread[begin + 4 : end]), mask)
        del unread[:end]
        self._count()
        return bool(first & 0x80), kind, content

    def _take(self, last: bool, kind: int, content: bytes) -> str | bytes | None:
        if kind == _CLOSE:
            raise self._fail(CLOSE_NORMAL, "its page closed it")
        if kind == _PING and self._pongs.allow(self._clock()):
            self._send(_PONG, content)
        if kind >= _CLOSE:
            return None
        if (kind == _MORE) != (self._kind != 0):
            raise self._fail(CLOSE_PROTOCOL, "parts of a message out of order")
        self._kind = self._kind or kind
        self._parts += content
        if not last:
            return None
        whole, kind = bytes(self._parts), self._kind
        self._parts.clear()
        self._kind = 0
        if kind == _BINARY:
            return whole
        try:
            return whole.decode()
        except UnicodeDecodeError:
            raise self._fail(CLOSE_NOT_TEXT, "a text that is not UTF-8") from None


def _unmasked(data: bytes, mask: bytes) -> bytes:
    length = len(data)
    pattern = (mask * (length // 4 + 1))[:length]
    mixed = int.from_bytes(data, "big") ^ int.from_bytes(pattern, "big")
    return mixed.to_bytes(length, "big")
