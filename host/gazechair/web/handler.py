"""The web server's connections, each limited in number, time and bytes."""

from __future__ import annotations

import contextlib
import json
import logging
import socket
import socketserver
import ssl
import sys
import threading
import time
from io import BytesIO
from typing import Any

from gazechair.base.throttled_log import ThrottledLog
from gazechair.web.connection import Connection, Patience, PlainConnection
from gazechair.web.connection_limits import OpenConnections
from gazechair.web.head import MOST_BODY_BYTES, MOST_HEAD_BYTES, Head, HeadRefused, parse
from gazechair.web.processor_share import Crowded, Shares
from gazechair.web.tls_socket import TlsSocket
from gazechair.web.websocket import tune

SETTLE = "gazechair.settle"  # in a request's environ: keeps the connection, OpenConnections.settle
CONNECTION = "gazechair.connection"
EARLY = "gazechair.early"
FILE = "gazechair.file"  # where a request's body is a file: call it once to receive it
_REQUEST_S = 5.0  # for head and body
_FILE_S = 60.0
_FILE_PAUSE_S = 0.005
_HANDSHAKE_S = 5.0
_SEND_S = 5.0
_DRAIN_S = 0.2
_DRAIN_BYTES = 65_536
_ACCEPT_PAUSE_S = 0.1
_TLS_HELLO = b"\x16"
_LETTERS = b"ABCDEFGHIJKLMNOPQRSTUVWXYZ"

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)


class Exchange:
    """One request of one connection, and its answer; then the connection ends."""

    def __init__(self, server: Server, connection: Connection, address: tuple[Any, ...]) -> None:
        self._server = server
        self._connection = connection
        self._address = address

    def run(self) -> None:
        """Answer the request. Raises OSError when the other side has disconnected."""
        try:
            text, rest = self._read_head()
            with self._server.strangers.turn():
                head = parse(text)
            if head.length > MOST_BODY_BYTES:
                self._answer_file(head, rest)
                return
            if len(rest) < head.length:
                rest += self._read_body(head.length - len(rest))
            self._answer(self._environ(head, rest), head)
        except HeadRefused as refused:
            throttled.warn("refused %s: %s", self._address[0], refused)
            self._refuse(refused.status, "bad_message", str(refused))
        except Crowded:
            self._refuse("503 Service Unavailable", "too_fast", "busy; ask again in a moment")

    def _refuse(self, status: str, reason: str, detail: str) -> None:
        text = json.dumps({"reason": reason, "detail": detail})
        _answer_plainly(self._connection, status, text, "application/json")
        self._drain()

    def _read_head(self) -> tuple[bytes, bytes]:
        end_s = time.monotonic() + _REQUEST_S
        patience = Patience()
        data = bytearray()
        while True:
            part = self._receive(MOST_HEAD_BYTES + 1 - len(data), end_s)
            searched = max(0, len(data) - 3)
            data += part
            if data[0] not in _LETTERS:
                raise HeadRefused("400 Bad Request", "no request of HTTP 1.1")
            at = data.find(b"\r\n\r\n", searched)
            if at >= 0:
                return bytes(data[:at]), bytes(data[at + 4 :])
            if len(data) > MOST_HEAD_BYTES:
                line = f"a request has at most {MOST_HEAD_BYTES} bytes"
                raise HeadRefused("431 Request Header Fields Too Large", line)
            patience.pause()

    def _read_body(self, missing: int) -> bytes:
        end_s = time.monotonic() + _REQUEST_S
        patience = Patience()
        data = b""
        while len(data) < missing:
            data += self._receive(missing - len(data), end_s)
            patience.pause()
        return data

    def _receive(self, size: int, end_s: float) -> bytes:
        part = self._connection.receive(size, end_s - time.monotonic())
        if part is None:
            raise HeadRefused("408 Request Timeout", "the request took too long")
        if not part:
            raise ConnectionResetError("gone in a request")
        return part

    def _answer_file(self, head: Head, rest: bytes) -> None:
        """The application decides whether the body is received: it is too large for strangers."""
        environ = self._environ(head, b"")
        received: list[bytes] = []

        def receive() -> None:
            received.append(self._read_file(rest, head.length))
            environ["wsgi.input"] = BytesIO(received[0])

        environ[FILE] = receive
        self._answer(environ, head)
        if not received:
            self._drain()

    def _read_file(self, rest: bytes, length: int) -> bytes:
        end_s = time.monotonic() + _FILE_S
        data = bytearray(rest)
        while len(data) < length:
            data += self._receive(length - len(data), end_s)
            time.sleep(_FILE_PAUSE_S)  # for pieces that are not tiny
        return bytes(data[:length])

    def _answer(self, environ: dict[str, Any], head: Head) -> None:
        response: list[Any] = ["500 Internal Server Error", []]

        def start(status: str, headers: list[tuple[str, str]], *_: Any) -> None:
            response[:] = [status, headers]

        content = b"".join(self._server.app(environ, start))
        status, headers = response
        lines = [f"{name}: {value}" for name, value in headers]
        text = "\r\n".join([f"HTTP/1.1 {status}", *lines, "Connection: close", "", ""])
        quiet = head.method == "HEAD" or status[:3] in ("204", "304")
        self._connection.sendall(text.encode("latin-1", "replace") + (b"" if quiet else content))

    def _environ(self, head: Head, body: bytes) -> dict[str, Any]:
        connections, raw = self._server.connections, self._connection.raw
        environ = {
            "wsgi.version": (1, 0),
            "wsgi.url_scheme": self._server.scheme,
            "wsgi.input": BytesIO(body[: head.length]),
            "wsgi.errors": sys.stderr,
            "wsgi.multithread": True,
            "wsgi.multiprocess": False,
            "wsgi.run_once": False,
            "REQUEST_METHOD": head.method,
            "SCRIPT_NAME": "",
            "PATH_INFO": head.path,
            "QUERY_STRING": head.query,
            "REMOTE_ADDR": self._address[0],
            "REMOTE_PORT": self._address[1],
            "SERVER_NAME": str(self._server.server_address[0]),
            "SERVER_PORT": str(self._server.port),
            "SERVER_PROTOCOL": head.version,
            "CONTENT_LENGTH": str(head.length),
            CONNECTION: self._connection,
            EARLY: body[head.length :],
            SETTLE: lambda what: connections.settle(raw, what),
        }
        for name, value in head.headers.items():
            key = name.upper().replace("-", "_")
            environ[key if key.startswith("CONTENT_") else f"HTTP_{key}"] = value
        return environ

    def _drain(self) -> None:
        # Closing with unread data would reset the connection, and the answer might be lost.
        with contextlib.suppress(OSError):
            self._connection.raw.shutdown(socket.SHUT_WR)
            end_s = time.monotonic() + _DRAIN_S
            patience = Patience()
            left = _DRAIN_BYTES
            while left > 0 and (part := self._connection.receive(left, end_s - time.monotonic())):
                left -= len(part)
                patience.pause()


class Server(socketserver.ThreadingMixIn, socketserver.TCPServer):
    """Accepts connections; everything that may take time runs on the connection's own thread."""

    daemon_threads = True
    block_on_close = False

    def __init__(
        self,
        listener: socket.socket,
        app: Any,
        strangers: Shares,
        context: ssl.SSLContext | None = None,
    ) -> None:
        """`app`: WSGI; `strangers` limits the work for unknown clients; `context`:
        encrypt; None: plain HTTP."""
        # BaseServer keeps a factory of handlers, which finish_request below does not use.
        socketserver.TCPServer.__init__(
            self, listener.getsockname(), socketserver.BaseRequestHandler, False
        )
        self.socket.close()
        self.socket = listener.dup()
        self.server_address = listener.getsockname()
        self.port: int = listener.getsockname()[1]
        self.app = app
        self.strangers = strangers
        self.scheme = "http" if context is None else "https"
        self.connections = OpenConnections(time.monotonic)
        self._context = context

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Accepts every connection; the oldest new one closes when there are too many."""
        for other in self.connections.admit(request, client_address[0]):
            throttled.warn(
                "%s: too many connections, one of %s ends", client_address[0], other.address
            )
        return True

    def service_actions(self) -> None:
        """Called by serve_forever after each connection, and at least every poll interval."""
        super().service_actions()
        self.connections.cut_overdue()
        # Accept connections only as fast as strangers' turns allow: others wait in the queue.
        self.strangers.bill()
        self.strangers.pause(_ACCEPT_PAUSE_S)

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        """Serve one connection, on its own thread."""
        threading.current_thread().name = f"web-request-{client_address[1]}"
        try:
            self.finish_request(request, client_address)
        except (OSError, Crowded):
            pass  # it has closed already, or was cut
        except Exception:
            throttled.warn("%s: error in a request", client_address[0], exc_info=True)
        finally:
            self.shutdown_request(request)
            self.connections.leave(request)
            self.strangers.bill()

    def finish_request(self, request: Any, client_address: Any) -> None:
        """Runs on the connection's own thread."""
        tune(request)
        request.settimeout(_SEND_S)
        if self._context is None:
            Exchange(self, PlainConnection(request), client_address).run()
            return
        connection = self._shake_hands(request, client_address[0])
        if connection is not None:
            try:
                Exchange(self, connection, client_address).run()
            finally:
                connection.send_close()

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Starting a thread failed."""
        self.connections.leave(request)
        throttled.warn("%s: no thread for a connection", client_address[0], exc_info=True)

    def _shake_hands(self, request: Any, address: str) -> TlsSocket | None:
        request.settimeout(_HANDSHAKE_S)
        first = request.recv(1, socket.MSG_PEEK)
        if first not in (b"", _TLS_HELLO):
            line = "this page is encrypted: open it with https://"
            _answer_plainly(PlainConnection(request), "400 Bad Request", line)
            return None
        assert self._context is not None
        connection = TlsSocket(request, self._context)
        try:
            connection.handshake(_HANDSHAKE_S, self.strangers)
        except OSError as error:  # ssl.SSLError is one
            throttled.warn("%s: no encryption agreed: %s", address, error)
            return None
        return connection


def _answer_plainly(
    connection: Connection, status: str, line: str, kind: str = "text/plain; charset=utf-8"
) -> None:
    """Answer a connection that has not reached the application."""
    text = (
        f"HTTP/1.1 {status}\r\nContent-Type: {kind}\r\n"
        f"Content-Length: {len(line) + 1}\r\nConnection: close\r\n\r\n{line}\n"
    )
    with contextlib.suppress(OSError):
        connection.sendall(text.encode())
