"""The simulator's control socket: one JSON object per line in each direction."""

from __future__ import annotations

import contextlib
import json
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

_LINE_LIMIT = 4096
_CLIENT_LIMIT = 16


class Control:
    """A unix socket whose requests are answered from `poll`, in the caller's thread.

    `handle` gets each request and returns its reply; its ValueError becomes {"error": reason}.
    """

    def __init__(self, path: Path, handle: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
        self.path = path
        self._handle = handle
        self._clients: dict[socket.socket, bytearray] = {}
        with contextlib.suppress(FileNotFoundError):
            path.unlink()
        self._server = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self._server.bind(str(path))
        except OSError as error:
            self._server.close()
            raise OSError(f"{path}: {error}; a socket's path must be under 108 bytes") from error
        self._server.listen(_CLIENT_LIMIT)
        self._server.setblocking(False)

    def close(self) -> None:
        """Close it and every connection."""
        for client in list(self._clients):
            self._drop(client)
        self._server.close()
        with contextlib.suppress(FileNotFoundError):
            self.path.unlink()

    def poll(self) -> None:
        """Answer the received requests; never waits."""
        with contextlib.suppress(BlockingIOError):
            client, _ = self._server.accept()
            if len(self._clients) >= _CLIENT_LIMIT:
                client.close()
            else:
                client.setblocking(False)
                self._clients[client] = bytearray()
        for client, pending in list(self._clients.items()):
            try:
                data = client.recv(4096)
            except BlockingIOError:
                continue
            except OSError:
                data = b""
            if not data:
                self._drop(client)
                continue
            pending += data
            while b"\n" in pending:
                line, _, rest = bytes(pending).partition(b"\n")
                pending[:] = rest
                self._answer(client, line)
            if len(pending) > _LINE_LIMIT:
                self._drop(client)

    def _answer(self, client: socket.socket, line: bytes) -> None:
        try:
            request = json.loads(line)
            if not isinstance(request, dict):
                raise ValueError("a request is a JSON object")
            reply = self._handle(request)
        except (ValueError, RecursionError) as error:
            reply = {"error": str(error)}
        try:
            client.sendall(json.dumps(reply).encode() + b"\n")
        except OSError:  # disconnected, or does not read its answers
            self._drop(client)

    def _drop(self, client: socket.socket) -> None:
        self._clients.pop(client, None)
        client.close()
