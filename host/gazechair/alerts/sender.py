"""The daemon's side of the process that sends alerts: hands over, gets results, never waits."""

from __future__ import annotations

import contextlib
import json
import socket
import time
from collections.abc import Callable
from typing import Any

from gazechair.alerts.book import ANSWER_S
from gazechair.alerts.child import LONGEST
from gazechair.alerts.message import Message
from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.reasons import PARTS
from gazechair.base.supervisor import Status, Supervised, Supervisor

LOST = "alerts_lost"
NO_BROKER = "alerts_mqtt"
_START_S = 30.0
_NICE = 10

Result = Callable[[int, str, str], None]


class Sender(Supervised):
    """Messages to people who are not at the chair."""

    def __init__(
        self, health: Health, result: Result, lost: Callable[[], None] = lambda: None
    ) -> None:
        """Calls `result(number, route, problem)` when an attempt has ended, and `lost` when the
        process has, from its own thread."""
        self._health = health
        self._result = result
        self._lost = lost

    def start(self) -> None:
        """Start the process."""
        self._ours, self._its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._ours.setblocking(False)
        self._supervisor = Supervisor(
            "gazechair.alerts.child",
            str(self._its.fileno()),
            self._on_alive,
            self._on_status,
            lost_reason=LOST,
            silent_s=PARTS["alerts"].silent_s,
            start_s=_START_S,
            nice=_NICE,
            fds=(self._its.fileno(),),
            on_facts=self._on_facts,
        )
        self._supervisor.start()

    def stop(self) -> None:
        """End the process."""
        if self._supervisor is not None:
            super().stop()
            self._ours.close()
            self._its.close()

    def send(self, number: int, route: str, url: str, message: Message) -> str:
        """Hand it over; returns why that is not possible, or "": the result will follow."""
        job = {
            "number": number,
            "route": route,
            "url": url,
            "title": message.title,
            "body": message.body,
            "till_s": time.monotonic() + ANSWER_S,
        }
        packet = json.dumps(job).encode()
        assert len(packet) <= LONGEST
        try:
            self._ours.send(packet)
        except OSError:
            return "too many messages are waiting"
        return ""

    def update_broker(self, url: str, node: str, state: dict[str, str]) -> None:
        """Pass the state on to the broker; call repeatedly: it is also the sign of life."""
        packet = json.dumps({"mqtt": url, "node": node, "state": state}).encode()
        with contextlib.suppress(OSError):
            self._ours.send(packet)

    def _on_alive(self, problem: bytes) -> None:
        if problem:
            self._health.set(states.DEGRADED, NO_BROKER, f"MQTT: {problem.decode()}")
        else:
            self._health.set(states.OK)

    def _on_facts(self, payload: bytes) -> None:
        found: dict[str, Any] = json.loads(payload)
        self._result(found["number"], found["route"], found["problem"])

    def _on_status(self, status: Status) -> None:
        self._health.set(status.state, status.reason, status.detail)
        if status.state == states.LOST:
            self._lost()
