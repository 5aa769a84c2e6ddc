"""The camera's part of the daemon: supervises the child process and keeps the newest picture."""

from __future__ import annotations

import json
from dataclasses import asdict

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status, Supervisor
from gazechair.config.configuration import CameraConfig
from gazechair.picture.camera.mjpeg import is_jpeg
from gazechair.picture.camera.record import LOST, Frame


class CameraService:
    """Runs the camera; `latest()` has its newest picture, however old that is."""

    def __init__(self, config: CameraConfig, health: Health) -> None:
        self._config = config
        self._health = health
        self._latest: Latest[Frame] = Latest()
        self._supervisor: Supervisor | None = None

    def latest(self) -> Latest[Frame]:
        """The slot of the newest picture; its birth time is the picture's acquisition."""
        return self._latest

    @property
    def restarts(self) -> int:
        """How often the child process had to be started again."""
        return self._supervisor.restarts if self._supervisor else 0

    @property
    def pid(self) -> int | None:
        """Process id of the child, None while there is none."""
        return self._supervisor.pid if self._supervisor else None

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
            silent_s=4.0,
        )
        self._supervisor.start()

    def stop(self) -> None:
        """End the child process and its thread."""
        if self._supervisor is not None:
            self._supervisor.stop()

    def _on_data(self, payload: bytes) -> None:
        frame = Frame.unpack(payload)
        if is_jpeg(frame.jpeg):
            self._latest.put(frame, frame.acquired_monotonic)
            self._health.set(states.OK)

    def _on_status(self, status: Status) -> None:
        if status.state == states.STARTING and self._health.state == states.LOST:
            return  # one more attempt: it stays lost, with its explanation, until it delivers
        self._health.set(status.state, status.reason, status.detail)
