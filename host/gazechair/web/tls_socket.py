"""An encrypted connection that one thread may read while another writes.

OpenSSL allows one thread at a time on a connection, and ssl.SSLSocket waits for the network inside
it. Here encryption works in memory, under a lock held for microseconds; waiting happens outside.
"""

from __future__ import annotations

import contextlib
import io
import socket
import ssl
import threading
import time
from typing import Any

_READ_SIZE = 16_384


class TlsSocket:
    """The part of socket.socket that Werkzeug and simple-websocket use. At most one reader."""

    def __init__(self, raw: socket.socket, context: ssl.SSLContext) -> None:
        self.raw = raw
        self._received = ssl.MemoryBIO()
        self._unsent = ssl.MemoryBIO()
        self._tls = context.wrap_bio(self._received, self._unsent, server_side=True)
        self._lock = threading.Lock()
        self._send_lock = threading.Lock()

    def handshake(self, limit_s: float) -> None:
        """Shake hands within `limit_s`. Raises OSError, ssl.SSLError among them."""
        end_s = time.monotonic() + limit_s
        while True:
            try:
                self._tls.do_handshake()
                self._flush()
                return
            except ssl.SSLWantReadError:
                self._flush()
            except ssl.SSLError:
                with contextlib.suppress(OSError):
                    self._flush()  # the alert that says why
                raise
            left_s = end_s - time.monotonic()
            if left_s <= 0:
                raise TimeoutError("the handshake took too long")
            self.raw.settimeout(left_s)
            data = self.raw.recv(_READ_SIZE)
            if not data:
                raise ConnectionResetError("gone in the handshake")
            self._received.write(data)

    def recv(self, size: int, flags: int = 0) -> bytes:
        """At most `size` bytes, b"" at the end. Raises OSError."""
        while True:
            with self._lock:
                try:
                    return self._tls.read(size)
                except ssl.SSLWantReadError:
                    answer_due = self._unsent.pending > 0
                except ssl.SSLZeroReturnError:
                    return b""
            if answer_due:
                self._flush()
            data = self.raw.recv(_READ_SIZE)
            if not data:
                return b""
            with self._lock:
                self._received.write(data)

    def sendall(self, data: Any) -> None:
        """Encrypt and send everything. Raises OSError."""
        if not len(data):
            return
        with self._send_lock:
            with self._lock:
                self._tls.write(data)
                out = self._unsent.read()
            self.raw.sendall(out)

    def send(self, data: Any) -> int:
        """As sendall; returns how many bytes that were: all."""
        self.sendall(data)
        return len(data)

    def say_goodbye(self) -> None:
        """Tell the other side that no more comes."""
        with contextlib.suppress(OSError):
            with self._lock, contextlib.suppress(ssl.SSLWantReadError):
                self._tls.unwrap()
            self._flush()

    def makefile(self, mode: str, bufsize: int = -1) -> io.BufferedReader:
        """A reader for request headers; `mode` is "rb"."""
        return io.BufferedReader(_Reader(self), bufsize if bufsize > 0 else _READ_SIZE)

    def _flush(self) -> None:
        with self._send_lock:
            with self._lock:
                out = self._unsent.read()
            if out:
                self.raw.sendall(out)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


class _Reader(io.RawIOBase):
    def __init__(self, connection: TlsSocket) -> None:
        self._connection = connection

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        data = self._connection.recv(len(buffer))
        buffer[: len(data)] = data
        return len(data)
