"""A page as a program on a bare socket: drives or floods, without the host's code."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import threading
import time
from collections import deque
from typing import Any

from gazemeasure.page import hostile

_LIMIT_S = 10.0
_HOLD_S = 0.025
_BEAT_S = 0.1
_ASK_S = 0.5
_TOKEN_KEPT_S = 0.5
_TEXT = 1


def frame(kind: int, data: bytes = b"", last: bool = True) -> bytes:
    """A WebSocket frame as a page sends it (RFC 6455): under 126 bytes, or with a 16-bit length."""
    mask = os.urandom(4)
    length = len(data)
    size = bytes([0x80 | length]) if length < 126 else b"\xfe" + struct.pack(">H", length)
    masked = bytes(byte ^ mask[at % 4] for at, byte in enumerate(data))
    return bytes([kind | 0x80 * last]) + size + mask + masked


def upgrade(port: int, path: str, cookie: str) -> socket.socket:
    """An open WebSocket. Raises ConnectionError when the host does not accept it."""
    line = socket.create_connection(("127.0.0.1", port), _LIMIT_S)
    line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    line.sendall(hostile.request(path, f"{hostile.UPGRADE}Cookie: {cookie}\r\n"))
    answer = b""
    while not answer.endswith(b"\r\n\r\n"):
        part = line.recv(1)
        if not part:
            break
        answer += part
    if not answer.startswith(b"HTTP/1.1 101"):
        raise ConnectionError(f"{path}: {answer[:80]!r}")
    return line


class RawDriver:
    """The driver's page, without a browser: use as a context, then arm, press and release."""

    def __init__(self, port: int, cookie: str) -> None:
        self._line = upgrade(port, "/ws/control", cookie)
        self._lock = threading.Lock()
        self._tokens: deque[tuple[int, float]] = deque(maxlen=50)  # token, time of arrival
        self._edge = 0
        self._held = False
        self.button: dict[str, Any] = {"k": "cmd", "verb": "forward", "mode": "continuous"}
        """The message of a press."""
        self._stopping = threading.Event()
        self.state: dict[str, Any] = {}
        self._threads = [
            threading.Thread(target=act, name=f"raw-driver-{name}", daemon=True)
            for name, act in (("read", self._read), ("beat", self._beat))
        ]

    def __enter__(self) -> RawDriver:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._stopping.set()
        with contextlib.suppress(OSError):
            self._line.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join(_LIMIT_S)
        self._line.close()

    @property
    def connected(self) -> bool:
        """True if the host has not closed the connection."""
        return self._threads[0].is_alive()

    @property
    def armed(self) -> bool:
        """True if driving is on, and this page owns the chair."""
        return self.state.get("state") == "armed" and bool(self.state.get("you"))

    def arm(self, limit_s: float = 30.0) -> None:
        """Request driving until it is on. Raises TimeoutError."""
        end_s = time.monotonic() + limit_s
        while not self.armed:
            if time.monotonic() > end_s:
                raise TimeoutError(f"driving does not go on: {self.state}")
            self._say({"k": "arm"})
            ask_s = time.monotonic() + _ASK_S
            while not self.armed and time.monotonic() < ask_s:
                self._stopping.wait(0.02)

    def send(self, message: dict[str, Any]) -> None:
        """Send any message at once."""
        self._say(message, fresh=False)

    def press(self) -> float:
        """A new press of its button, active from now on; returns its time (CLOCK_MONOTONIC, s)."""
        with self._lock:
            self._edge += 1
            self._held = True
        now_s = time.monotonic()
        self._hold()
        return now_s

    def release(self) -> float:
        """Release; returns the time of sending."""
        with self._lock:
            self._held = False
        now_s = time.monotonic()
        self._say({"k": "stop"}, fresh=False)
        return now_s

    def _hold(self) -> None:
        self._say({**self.button, "edge": self._edge})

    def _say(self, message: dict[str, Any], fresh: bool = True) -> None:
        if fresh:
            now_s = time.monotonic()
            known = [(t, at) for t, at in list(self._tokens) if now_s - at <= _TOKEN_KEPT_S]
            if not known:
                return
            token, at_s = max(known, key=lambda pair: pair[0] - 1000 * pair[1])
            message |= {"token": token, "since": int(1000 * (now_s - at_s))}
        with self._lock, contextlib.suppress(OSError):
            self._line.sendall(frame(_TEXT, json.dumps(message).encode()))

    def _beat(self) -> None:
        beat_s = 0.0
        while not self._stopping.wait(_HOLD_S):
            if self._held:
                self._hold()
            if time.monotonic() - beat_s >= _BEAT_S:
                beat_s = time.monotonic()
                self._say({"k": "hb"})

    def _read(self) -> None:
        with contextlib.suppress(OSError):
            reader = self._line.makefile("rb")
            while not self._stopping.is_set():
                head = reader.read(2)
                if len(head) < 2:
                    return
                length = head[1] & 127
                if length == 126:
                    length = int.from_bytes(reader.read(2), "big")
                elif length == 127:
                    length = int.from_bytes(reader.read(8), "big")
                data = reader.read(length)
                if head[0] & 15 == _TEXT:
                    self._hear(json.loads(data))

    def _hear(self, message: dict[str, Any]) -> None:
        if "token" in message:
            self._tokens.append((message["token"], time.monotonic()))
        if message["k"] == "state":
            self.state = message
