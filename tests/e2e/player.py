"""Plays the driver's page against a running daemon: a WebSocket client with a thread of its own."""

from __future__ import annotations

import contextlib
import json
import threading
import time
from collections import deque
from typing import Any

from simple_websocket import Client, ConnectionClosed, ConnectionError
from wsproto.utilities import LocalProtocolError

from gazechair.driving.control import HEARTBEAT_MS

_BEAT_S = 0.1
_HOLD_S = HEARTBEAT_MS / 1000
_TOKEN_KEPT_S = 0.5
_RETRY_S = 0.2
# The last: the host's end was heard a moment before the library said so.
_GONE = (ConnectionClosed, ConnectionError, OSError, LocalProtocolError)


class Player:
    """Connects again by itself. `stop` ends the thread."""

    def __init__(self, url: str, cookie: str) -> None:
        self._url = url.replace("http", "ws") + "ws/control"
        self._headers = {"Cookie": cookie}
        self._lock = threading.Lock()
        self._held: dict[str, Any] | None = None
        self._once: list[dict[str, Any]] = []
        self._edge = 0
        self._tokens: deque[tuple[int, float]] = deque(maxlen=50)  # token, time of arrival
        self.state: dict[str, Any] = {}
        self.refused: list[str] = []
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="player", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Close the page."""
        self._stopping.set()
        self._thread.join(10.0)

    def arm(self) -> None:
        """Choose "driving on"."""
        self._say(k="arm")

    def press(self, verb: str, mode: str = "continuous") -> None:
        """A new press, held from now on."""
        with self._lock:
            self._edge += 1
            self._held = {"k": "cmd", "verb": verb, "mode": mode, "edge": self._edge}

    def release(self) -> None:
        """Leave the button."""
        with self._lock:
            self._held = None
        self._say(k="stop")

    def _say(self, **message: Any) -> None:
        with self._lock:
            self._once.append(message)

    def _run(self) -> None:
        while not self._stopping.is_set():
            with contextlib.suppress(*_GONE):
                self._serve(Client(self._url, headers=self._headers))
            self.state = {}
            self._tokens.clear()
            self._stopping.wait(_RETRY_S)

    def _serve(self, socket: Client) -> None:
        beat_s = hold_s = 0.0
        try:
            while not self._stopping.is_set():
                self._hear(socket)
                proof = self._proof()
                if proof is None:
                    continue
                now_s = time.monotonic()
                with self._lock:
                    due, self._once = self._once, []
                    if self._held and now_s - hold_s >= _HOLD_S:
                        hold_s = now_s
                        due.append(self._held)
                if now_s - beat_s >= _BEAT_S:
                    beat_s = now_s
                    due.append({"k": "hb"})
                for message in due:
                    socket.send(json.dumps({**message, **proof}))
        finally:
            with contextlib.suppress(*_GONE):
                socket.close()

    def _proof(self) -> dict[str, int] | None:
        # The token that was delayed least, and how long it has been here.
        now_s = time.monotonic()
        known = [(token, at_s) for token, at_s in self._tokens if now_s - at_s <= _TOKEN_KEPT_S]
        if not known:
            return None
        token, at_s = max(known, key=lambda pair: pair[0] - 1000 * pair[1])
        return {"token": token, "since": int(1000 * (now_s - at_s))}

    def _hear(self, socket: Client) -> None:
        text = socket.receive(timeout=0.01)
        while text is not None:
            message = json.loads(text)
            if "token" in message:
                self._tokens.append((message["token"], time.monotonic()))
            if message["k"] == "state":
                self.state = message
            elif message["k"] == "refused":
                self.refused.append(message["reason"])
            text = socket.receive(timeout=0)
