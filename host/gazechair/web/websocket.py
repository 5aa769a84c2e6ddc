"""WebSocket limits beyond the library flask-sock: size limits, complete sends, no extra threads.

The library implements the protocol (RFC 6455), without extensions. Everything that arrives counts,
also pings, empty fragments and single bytes: a page that sends more than it ever needs is
disconnected, which stops what it commanded.
"""

from __future__ import annotations

import base64
import binascii
import contextlib
import socket
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from simple_websocket import ConnectionClosed
from wsproto import WSConnection
from wsproto.connection import ConnectionState
from wsproto.events import CloseConnection, Event, Message, Ping
from wsproto.utilities import LocalProtocolError

from gazechair.base.latest_value import Clock
from gazechair.base.rate_limit import RateLimit
from gazechair.web.connection import Connection, cut

MOST_MESSAGE = 1024
"""Characters, or bytes of a binary one. Above this a socket is closed; a control message above 256
bytes is refused with a message first."""
ARRIVALS_PER_S = 1000
"""Of one device's sockets together: frames and reads of the connection."""
_COST_OF_OPENING = 50
_PONGS_PER_S = 10
_READ_SIZE = 4096
_SEND_BUFFER = 32_768  # 4 MB by default: seconds of stale state before a slow reader
_RECEIVE_BUFFER = 32_768  # what a flood may pile up before it is cut
_PEER_GONE_MS = 3_000
_KEY_BYTES = 16
_FLOOD = "far too many messages"

# RFC 6455 section 7.4.1, and the IANA registry for the last one.
CLOSE_NORMAL = 1000
CLOSE_GOING_AWAY = 1001
CLOSE_UNSUPPORTED = 1003
CLOSE_POLICY = 1008
CLOSE_TRY_LATER = 1013
CLOSE_REVOKED = 4001  # our own; see docs/developing-pages.md


class Ended(ConnectionError):
    """The socket has ended; the text gives the reason."""


class BadHandshake(Exception):
    """Raised for a request that cannot become a WebSocket: one plain line."""


class _Fed(Exception):
    """Raised when the library has read everything that it was given."""


def tune(connection: socket.socket) -> None:
    """Set options: send small messages at once, queue little, detect a dead peer in 3 s."""
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _PEER_GONE_MS)


def handshake(environ: Mapping[str, Any]) -> dict[str, Any]:
    """A WebSocket's request for the library, only with the headers that were checked here.

    Raises BadHandshake.
    """
    key = str(environ.get("HTTP_SEC_WEBSOCKET_KEY", ""))
    options = {word.strip(" \t") for word in str(environ.get("HTTP_CONNECTION", "")).split(",")}
    if "upgrade" not in {option.lower() for option in options}:
        raise BadHandshake("this address is a WebSocket's")
    if str(environ.get("HTTP_UPGRADE", "")).lower() != "websocket":
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
    checked = {name: value for name, value in environ.items() if not name.startswith("HTTP_")}
    return checked | {
        "HTTP_HOST": "gazechair",
        "HTTP_UPGRADE": "websocket",
        "HTTP_CONNECTION": "Upgrade",
        "HTTP_SEC_WEBSOCKET_VERSION": "13",
        "HTTP_SEC_WEBSOCKET_KEY": key,
    }


class Arrivals:
    """Limits what one device sends on all its sockets, including reopened ones. Thread-safe."""

    def __init__(self, clock: Clock = time.monotonic) -> None:
        self._clock = clock
        self._lock = threading.Lock()
        self._limit = RateLimit(ARRIVALS_PER_S, ARRIVALS_PER_S)

    def allow(self) -> bool:
        """Something has arrived; False when it is too much."""
        with self._lock:
            return self._limit.allow(self._clock())

    def allow_opening(self) -> bool:
        """A socket is being opened; False when that is too much."""
        with self._lock:
            return self._limit.allow(self._clock(), _COST_OF_OPENING)


class Line:
    """The library's socket object: reads what it is fed, and sends completely."""

    def __init__(
        self,
        connection: Connection,
        arrivals: Arrivals,
        early: bytes = b"",
        clock: Clock = time.monotonic,
    ) -> None:
        """`arrivals`: its device's; `early`: data received after the handshake's request."""
        self.connection = connection
        self.arrivals = arrivals
        self.clock = clock
        self.sending = threading.RLock()
        self.opened = False
        """True once something was sent: the connection is a WebSocket from then on."""
        self.ended = ""
        """Why nothing is sent or received any longer."""
        self._early = early
        self._fed = b""

    def take(self, limit_s: float) -> bytes | None:
        """The next data, uncounted, b"" at the end, None when none came in time. OSError."""
        if self._early:
            early, self._early = self._early, b""
            return early
        return self.connection.receive(_READ_SIZE, limit_s)

    def feed(self, part: bytes) -> None:
        """Have `recv` return this once."""
        self._fed = part

    def recv(self, _size: int) -> bytes:
        """For the library, which has nothing more to do when this raises _Fed."""
        part, self._fed = self._fed, b""
        if not part:
            raise _Fed
        return part

    def send(self, data: bytes) -> int:
        """For the library. Raises OSError."""
        with self.sending:
            if self.ended:
                raise Ended(self.ended)
            self.opened = True
            self.connection.sendall(data)
        return len(data)

    def close(self) -> None:
        """For the library; the server closes the connection."""


class NoReaderThread:
    """The library's receiving thread, disabled: the receiver reads on its own thread."""

    name = "web-socket-read"

    def __init__(self, target: Callable[[], None]) -> None:
        self.read = target

    def start(self) -> None:
        """Does nothing."""


LIBRARY_OPTIONS = {"max_message_size": MOST_MESSAGE, "thread_class": NoReaderThread}


class _Counting:
    """The library's protocol engine; counts every frame."""

    def __init__(self, engine: WSConnection, line: Line) -> None:
        self._engine = engine
        self._line = line
        self._pongs = RateLimit(_PONGS_PER_S, _PONGS_PER_S)
        self.send = engine.send
        self.receive_data = engine.receive_data
        self.why = ""
        """Why the library closes or closed."""

    def events(self) -> Iterator[Event]:
        for event in self._engine.events():
            # Part of a frame comes from one read, which is counted itself.
            counts = not isinstance(event, Message) or event.frame_finished
            if counts and not self._line.arrivals.allow():
                self.why = _FLOOD
                yield CloseConnection(CLOSE_POLICY, _FLOOD)  # the library sends it, and ends
                return
            if isinstance(event, Ping) and not self._pongs.allow(self._line.clock()):
                continue
            if isinstance(event, CloseConnection):
                by_page = self._engine.state is ConnectionState.REMOTE_CLOSING
                self.why = "its page closed it" if by_page else str(event.reason)
            yield event


class WebSocket:
    """One socket: one thread receives; any may send, close or hang up."""

    def __init__(self, library: Any) -> None:
        """`library`: a simple_websocket.Server on a Line, made with LIBRARY_OPTIONS."""
        self._library = library
        self._line: Line = library.sock
        self._counting = library.ws = _Counting(library.ws, self._line)

    def receive(self, limit_s: float) -> str | bytes | None:
        """The next message, None when none came within `limit_s`. Raises OSError: it has ended."""
        clock = self._line.clock
        end_s = clock() + limit_s
        while True:
            if self._line.ended:
                raise Ended(self._line.ended)
            if self._library.input_buffer:
                message: str | bytes = self._library.receive(0)
                return message
            if not self._library.connected:
                self._line.ended = self._counting.why or "its socket ended"
                continue
            part = self._line.take(end_s - clock())
            if part is None:
                return None
            self._read(part)
            if not self._library.input_buffer and self._library.connected and clock() > end_s:
                return None

    def send(self, data: str | bytes) -> None:
        """Send a message whole, after what another thread is sending. Raises OSError."""
        self._through(lambda: self._library.send(data))

    def close(self, code: int = CLOSE_NORMAL, why: str = "") -> None:
        """Send the reason, and end. Raises OSError when it can no longer be sent."""
        with self._line.sending:
            try:
                self._through(lambda: self._library.close(code, why))
            finally:
                self._line.ended = self._line.ended or why or "closed"

    def hang_up(self) -> None:
        """Cut the connection now: threads that block on it, sending or receiving, wake up."""
        cut(self._line.connection)

    def _through(self, act: Callable[[], None]) -> None:
        # Under the lock from the start: the engine's state and the data sent keep one order.
        with self._line.sending:
            if self._line.ended:
                raise Ended(self._line.ended)
            try:
                act()
            except (ConnectionClosed, LocalProtocolError):
                raise Ended(self._counting.why or "its socket ended") from None

    def _read(self, part: bytes) -> None:
        if not part:
            self._line.ended = "its connection ended"
            return
        if not self._line.arrivals.allow():
            with contextlib.suppress(OSError):
                self.close(CLOSE_POLICY, _FLOOD)
            return
        self._line.feed(part)
        with contextlib.suppress(_Fed):
            self._library.thread.read()
