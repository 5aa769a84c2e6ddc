"""The driver's page in lockstep: it sends by the rules of web/ while a button is pressed."""

from __future__ import annotations

import json
from collections import deque
from typing import Any

from gazechair.driving.control import HEARTBEAT_MS
from gazesim.lockstep_host import Host

BEAT_MS = 100
STATE_MS = 100  # between the host's states when nothing changes
TOKEN_MS = 50
TOKEN_KEPT_MS = 500
NO_VERSION = -1


class Page:
    """A page with its socket. `alive` False: its scripts stand still, the socket stays open."""

    def __init__(self, host: Host, role: str = "driver") -> None:
        self._role = role
        self.alive = True
        self.stalled = False  # the network delivers nothing in either direction
        self.edge = 0
        self._held: dict[str, Any] | None = None
        self.delay_ms = 0  # of the network, in each direction
        self.proved_ms = 0  # when it last sent that a button is pressed
        self._now_ms = 0
        self._waiting: deque[tuple[int, str]] = deque()
        self._coming: deque[tuple[int, dict[str, Any]]] = deque()
        self._tokens: deque[tuple[int, int]] = deque()  # token, time of arrival
        self.shown: dict[str, Any] = {}
        self.open(host)

    def open(self, host: Host) -> None:
        """Connect its socket to `host`."""
        self._host = host
        self.client = host.control.connect(self._role)
        self._waiting.clear()
        self._tokens.clear()
        self._coming.clear()
        self._version = 0
        self.open_socket = True
        self._hear(host.look(self.client))

    def close(self) -> None:
        """Its socket closes."""
        self.open_socket = False
        self._host.control.disconnect(self.client)

    def one_ms(self, now_ms: int) -> None:
        """One millisecond of the page's life, and of the network between it and the host."""
        self._now_ms = now_ms
        if not self.open_socket:
            return
        host = self._host
        if not host.frozen:
            version = host.control.wait_change(0.0, NO_VERSION)  # at once
            if now_ms % STATE_MS == 0 or version != self._version:
                self._version = version
                self._coming.append((now_ms + self.delay_ms, host.look(self.client)))
            elif now_ms % TOKEN_MS == 0:
                token = {"token": host.control.token()}
                self._coming.append((now_ms + self.delay_ms, token))
        while self._coming and self._coming[0][0] <= now_ms and not self.stalled:
            self._hear(self._coming.popleft()[1])
        if self.alive and now_ms % BEAT_MS == 0:
            self._send_fresh(k="hb")
        if self.alive and self._held and now_ms % HEARTBEAT_MS == 0:
            self._say_held()
        while self._waiting and self._waiting[0][0] <= now_ms and not self.stalled:
            host.inbox.append((self.client, self._waiting.popleft()[1]))

    def _hear(self, state: dict[str, Any]) -> None:
        if self.alive:
            self.shown = {**self.shown, **state}
            self._tokens.append((state["token"], self._now_ms))
            while self._now_ms - self._tokens[0][1] > TOKEN_KEPT_MS:
                self._tokens.popleft()

    def _send(self, **message: Any) -> None:
        self._waiting.append((self._now_ms + self.delay_ms, json.dumps(message)))

    def _send_fresh(self, **message: Any) -> None:
        # The least delayed token, and the time since it arrived.
        known = [(t, at) for t, at in self._tokens if self._now_ms - at <= TOKEN_KEPT_MS]
        if known:
            token, at = max(known, key=lambda pair: pair[0] - pair[1])
            self._send(**message, token=token, since=self._now_ms - at)

    def say(self, **message: Any) -> None:
        """Send any message at once."""
        self._send(**message)

    # What the driver does

    def arm(self) -> None:
        """Choose "driving on"."""
        self._send_fresh(k="arm")

    def take(self) -> None:
        """Take over from the present owner."""
        self._send_fresh(k="take")

    def reset(self) -> None:
        """Clear the latched faults."""
        self._send_fresh(k="reset")

    def press(self, verb: str, mode: str = "continuous") -> None:
        """Press a button and keep it pressed."""
        self.edge += 1
        self._held = {"k": "cmd", "verb": verb, "mode": mode}
        self._say_held()

    def choose(self, mode: str) -> None:
        """Dwell once on the tile of a mode that nobody holds."""
        self._held = None
        self.edge += 1
        self._send_fresh(k="mode", mode=mode, edge=self.edge)

    def spot(self, tile: str, at: tuple[float, float] | None) -> None:
        """Dwell on a spot of the picture, for that tile."""
        self._send_fresh(k="spot", tile=tile, at=at)

    def look(self) -> None:
        """Send that the driver looks at the page, which supervises an auto motion."""
        self._send_fresh(k="watch")

    def pull(self, linear: int, turn: int) -> None:
        """Hold the stick at this position: a new press if it was not held."""
        if self._held is None or self._held["k"] != "drive":
            self.edge += 1
        self._held = {"k": "drive", "linear": linear, "turn": turn}
        self._say_held()

    def _say_held(self) -> None:
        assert self._held is not None
        self.proved_ms = self._now_ms
        self._send_fresh(**self._held, edge=self.edge)

    def release(self) -> None:
        """Leave the button."""
        self._held = None
        self._send(k="stop")

    def forget_button(self) -> None:
        """The button is released without a stop (a lost message)."""
        self._held = None
