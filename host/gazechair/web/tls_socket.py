"""An encrypted connection that one thread may read while another writes.

OpenSSL allows one thread at a time on a connection, and ssl.SSLSocket waits for the network inside
it. Here encryption works in memory, under a lock that lasts microseconds; waiting happens outside.
"""

from __future__ import annotations

import contextlib
import socket
import ssl
import threading
import time
from typing import Any

from gazechair.web.connection import Patience, readable
from gazechair.web.processor_share import Shares

_READ_SIZE = 16_384


class TlsSocket:
    """An encrypted Connection."""

    def __init__(self, raw: socket.socket, context: ssl.SSLContext) -> None:
        self.raw = raw
        self._received = ssl.MemoryBIO()
        self._unsent = ssl.MemoryBIO()
        self._tls = context.wrap_bio(self._received, self._unsent, server_side=True)
        self._lock = threading.Lock()
        self._send_lock = threading.Lock()

    def handshake(self, limit_s: float, share: Shares) -> None:
        """Shake hands within `limit_s`, in turns of `share`.

        Raises OSError (ssl.SSLError too), Crowded.
        """
        end_s = time.monotonic() + limit_s
        patience = Patience()
        while True:
            try:
                with share.turn():
                    self._tls.do_handshake()
                self._flush()
                return
            except ssl.SSLWantReadError:
                self._flush()
            except ssl.SSLError:
                with contextlib.suppress(OSError):
                    self._flush()  # the alert with the reason
                raise
            if not readable(self.raw, end_s - time.monotonic()):
                raise TimeoutError("the handshake took too long")
            data = self.raw.recv(_READ_SIZE)
            if not data:
                raise ConnectionResetError("gone in the handshake")
            self._received.write(data)
            patience.pause()

    def receive(self, size: int, limit_s: float) -> bytes | None:
        """See Connection."""
        end_s = time.monotonic() + limit_s
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
            if not readable(self.raw, end_s - time.monotonic()):
                return None
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

    def send_close(self) -> None:
        """Signal the other side that nothing more will be sent."""
        with contextlib.suppress(OSError):
            with self._lock, contextlib.suppress(ssl.SSLWantReadError):
                self._tls.unwrap()
            self._flush()

    def _flush(self) -> None:
        with self._send_lock:
            with self._lock:
                out = self._unsent.read()
            if out:
                self.raw.sendall(out)
