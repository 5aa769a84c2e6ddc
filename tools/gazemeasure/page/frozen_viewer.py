"""A viewer that opens both sockets and then never reads or answers again."""

from __future__ import annotations

import base64
import os
import socket

_LIMIT_S = 10.0
_HANDSHAKE = (
    "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
    "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n"
    "Cookie: {cookie}\r\n\r\n"
)


class FrozenViewer:
    """Use as a context. Raises ConnectionError when the host does not accept it."""

    def __init__(self, port: int, cookie: str) -> None:
        self._sockets = [self._open(port, path, cookie) for path in ("/ws/control", "/ws/video")]

    def _open(self, port: int, path: str, cookie: str) -> socket.socket:
        connection = socket.create_connection(("127.0.0.1", port), timeout=_LIMIT_S)
        key = base64.b64encode(os.urandom(16)).decode()
        request = _HANDSHAKE.format(path=path, port=port, key=key, cookie=cookie)
        connection.sendall(request.encode())
        answer = connection.recv(64)
        if b" 101 " not in answer:
            raise ConnectionError(f"{path}: {answer!r}")
        return connection

    def __enter__(self) -> FrozenViewer:
        return self

    def __exit__(self, *_error: object) -> None:
        for connection in self._sockets:
            connection.close()
