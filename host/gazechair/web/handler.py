"""Werkzeug's server with bounded connections: handshake, headers and idleness cost nobody else."""

from __future__ import annotations

import contextlib
import logging
import socket
import ssl
import threading
import time
from typing import Any

from werkzeug.serving import ThreadedWSGIServer, WSGIRequestHandler

from gazechair.web.complaints import Complaints
from gazechair.web.places import Places
from gazechair.web.sockets import tune
from gazechair.web.tls_socket import TlsSocket

SETTLE = (
    "gazechair.settle"  # in a request's environ: call to keep the connection; see Places.settle
)
MOST_HEADER_BYTES = 16_384
_HEADERS_S = 5.0
_HANDSHAKE_S = 5.0
_TLS_HELLO = b"\x16"

log = logging.getLogger(__name__)
complaints = Complaints(log)


class _TooMuch(Exception):
    pass


class _Bounded:
    """A request's reader that gives up after so many bytes."""

    def __init__(self, reader: Any, most: int) -> None:
        self._reader = reader
        self._left = most

    def readline(self, size: int = -1) -> bytes:
        return self._count(self._reader.readline(self._limit(size)))

    def read(self, size: int = -1) -> bytes:
        return self._count(self._reader.read(self._limit(size)))

    def _limit(self, size: int) -> int:
        return self._left + 1 if size < 0 else min(size, self._left + 1)

    def _count(self, data: bytes) -> bytes:
        self._left -= len(data)
        if self._left < 0:
            raise _TooMuch
        return data

    def __getattr__(self, name: str) -> Any:
        return getattr(self._reader, name)


class Handler(WSGIRequestHandler):
    """One request of one connection."""

    timeout = _HEADERS_S  # for each read of request headers; a socket's upgrade removes it

    def setup(self) -> None:
        threading.current_thread().name = f"web-request-{self.client_address[1]}"
        super().setup()
        self.rfile = _Bounded(self.rfile, MOST_HEADER_BYTES)  # type: ignore[assignment]

    def handle_one_request(self) -> None:
        """Answer, or refuse in one line a request that is too long."""
        try:
            super().handle_one_request()
        except _TooMuch:
            self.close_connection = True
            line = f"a request has at most {MOST_HEADER_BYTES} bytes"
            say_plainly(self.connection, "431 Request Header Fields Too Large", line)

    def make_environ(self) -> Any:
        environ = super().make_environ()
        server = self.server
        assert isinstance(server, Server)
        raw = getattr(self.connection, "raw", self.connection)
        environ[SETTLE] = lambda what: server.places.settle(raw, what)
        return environ

    def version_string(self) -> str:
        return "gazechair"

    def connection_dropped(self, error: BaseException, environ: Any = None) -> None:
        # Else what a closed socket's client still sent would be read as a next HTTP request.
        self.close_connection = True

    def log_request(self, code: int | str = "-", size: int | str = "-") -> None:
        log.debug("%s %s %s", self.client_address[0], self.requestline, code)

    def log(self, type: str, message: str, *args: Any) -> None:
        complaints.warn("%s: %s", self.client_address[0], message % args)


class Server(ThreadedWSGIServer):
    """Accepts, and leaves everything that may take time to the connection's own thread."""

    def __init__(
        self, listener: socket.socket, app: Any, context: ssl.SSLContext | None = None
    ) -> None:
        """`context`: encrypt; None: plain HTTP."""
        host, port = listener.getsockname()[:2]
        super().__init__(host, port, app, handler=Handler, fd=listener.fileno())
        self.places = Places(time.monotonic)
        self._context = context

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Lets everyone in; who has been new for longest goes when there are too many."""
        for place in self.places.admit(request, client_address[0]):
            complaints.warn(
                "%s: too many connections, one of %s ends", client_address[0], place.address
            )
        return True

    def service_actions(self) -> None:
        """Called by serve_forever at least every poll interval."""
        super().service_actions()
        self.places.cut_overdue()

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self.places.leave(request)

    def finish_request(self, request: Any, client_address: Any) -> None:
        """Runs on the connection's own thread."""
        with contextlib.suppress(OSError):  # it has gone already
            tune(request)
            if self._context is None:
                super().finish_request(request, client_address)
                return
            connection = self._shake_hands(request, client_address[0])
            if connection is not None:
                Handler(connection, client_address, self)  # type: ignore[arg-type]
                connection.say_goodbye()

    def _shake_hands(self, request: Any, address: str) -> TlsSocket | None:
        request.settimeout(_HANDSHAKE_S)
        first = request.recv(1, socket.MSG_PEEK)
        if first not in (b"", _TLS_HELLO):
            say_plainly(request, "400 Bad Request", "this page is encrypted: open it with https://")
            return None
        assert self._context is not None
        connection = TlsSocket(request, self._context)
        try:
            connection.handshake(_HANDSHAKE_S)
        except (OSError, ssl.SSLError) as error:
            complaints.warn("%s: no encryption agreed: %s", address, error)
            return None
        return connection


def say_plainly(connection: Any, status: str, line: str) -> None:
    """Answer a connection that has not got as far as the application."""
    text = (
        f"HTTP/1.0 {status}\r\nContent-Type: text/plain; charset=utf-8\r\n"
        f"Content-Length: {len(line) + 1}\r\nConnection: close\r\n\r\n{line}\n"
    )
    with contextlib.suppress(OSError):
        connection.sendall(text.encode())
