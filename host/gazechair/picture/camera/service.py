"""The camera's part of the daemon: supervises the child process and keeps the newest picture."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.config.configuration import CameraConfig
from gazechair.picture.camera.mjpeg import is_jpeg
from gazechair.picture.camera.record import LOST, Frame

_SILENT_S = 3.0  # longer than PARTS["camera"]: a slow picture is no reason to open it anew
_LONGEST_PAUSE_S = 3.0  # with its start within 5 s of being there again


class CameraService(Supervised):
    """Runs the camera; `latest()` has its newest picture, however old that is."""

    def __init__(self, config: CameraConfig, health: Health) -> None:
        self._config = config
        self._health = health
        self._latest: Latest[Frame] = Latest()
        self._takes: list[Callable[[bytes, float], None]] = []

    def latest(self) -> Latest[Frame]:
        """The slot of the newest picture; its birth time is the picture's acquisition."""
        return self._latest

    def subscribe(self, take: Callable[[bytes, float], None]) -> None:
        """Before the start: `take` gets each picture, and when it was taken; it must not wait."""
        self._takes.append(take)

    def start(self) -> None:
        """Start the child process; with kind "off" there is none and that is no fault."""
        if self._config.kind == "off":
            self._health.set(states.OK, "ok", "no camera is configured")
            return
        self._supervisor = Supervisor(
            "gazechair.picture.camera.child",
            json.dumps(asdict(self._config)),
            self._on_data,
            self._on_status,
            lost_reason=LOST,
            silent_s=_SILENT_S,
            longest_pause_s=_LONGEST_PAUSE_S,
        )
        self._supervisor.start()

    def _on_data(self, payload: bytes) -> None:
        frame = Frame.unpack(payload)
        if is_jpeg(frame.jpeg):
            self._latest.put(frame, frame.acquired_monotonic)
            for take in self._takes:
                take(frame.jpeg, frame.acquired_monotonic)
            self._health.set(states.OK)

    def _on_status(self, status: Status) -> None:
        if status.state == states.STARTING and self._health.state == states.LOST:
            return  # one more attempt: it stays lost, with its explanation, until it delivers
        self._health.set(status.state, status.reason, status.detail)
