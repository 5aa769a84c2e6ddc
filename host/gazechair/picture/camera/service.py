"""The camera's part of the daemon: supervises the child process and keeps the newest picture."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict

from gazechair.base import health as states
from gazechair.base.health import Health
from gazechair.base.latest_value import Latest
from gazechair.base.supervisor import Status, Supervised, Supervisor
from gazechair.config.settings import CameraConfig
from gazechair.picture.camera.mjpeg import is_jpeg
from gazechair.picture.camera.record import LOST, Frame

_SILENT_S = 3.0  # longer than PARTS["camera"]: do not reopen the camera for a slow picture
_LONGEST_PAUSE_S = 3.0  # so that a camera is back within 5 s after it is plugged in


class CameraService(Supervised):
    """Runs the camera; `latest()` has its newest picture, however old that is."""

    def __init__(self, config: CameraConfig, health: Health) -> None:
        self._config = config
        self._health = health
        self._latest: Latest[Frame] = Latest()
        self._takes: list[Callable[[bytes, float], None]] = []

    def latest(self) -> Latest[Frame]:
        """The slot of the newest picture; its birth time is the acquisition time."""
        return self._latest

    def subscribe(self, take: Callable[[bytes, float], None]) -> None:
        """Call before `start`: `take` gets each picture and its time; it must not block."""
        self._takes.append(take)

    def start(self) -> None:
        """Start the child process; with kind "off" there is none, which is not a fault."""
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
            return  # another attempt: the part stays lost, with its reason, until it delivers
        self._health.set(status.state, status.reason, status.detail)
