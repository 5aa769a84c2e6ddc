"""All producers of the daemon, served by two threads.

One follows presses. The other updates what can be chosen, and may wait for a disk.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Sequence
from typing import Any

from gazechair.base.health import Health
from gazechair.base.throttled_log import ThrottledLog
from gazechair.config.settings import LidarConfig
from gazechair.driving.mode_context import IDLE_LOOK_S, PRESSED_LOOK_S
from gazechair.producers.chair_settings import ChairSettings, Link
from gazechair.producers.service import Port, ProducerService
from gazechair.producers.spot_service import At, SpotService

_OFFER_S = 0.25

log = logging.getLogger(__name__)


class Producers:
    """Starts and stops them, and ticks them."""

    def __init__(self, services: Sequence[ProducerService]) -> None:
        self.services = tuple(services)
        self._spots = [one for one in self.services if isinstance(one, SpotService)]
        self._settings: ChairSettings
        self._stopping = threading.Event()
        self._log = ThrottledLog(log)
        self._threads = [
            threading.Thread(target=run, name=name, daemon=True)
            for run, name in ((self._run, "producers"), (self._offer, "producers' tiles"))
        ]

    def connect(self, port: Port, link: Link) -> None:
        """Before the start."""
        self._settings = ChairSettings(link)

        def override() -> str:
            state = link.state()
            return "" if state is None else str(state.override_name)

        for service in self.services:
            service.connect(port, lambda: self._settings.known, override)

    def start(self, start: Callable[[ProducerService, Health], None]) -> None:
        """Start each with `start`, which reports a failure in its health."""
        for service in self.services:
            start(service, service.health)
        for thread in self._threads if self.services else ():
            thread.start()

    def stop(self) -> None:
        """End all processes and threads. Writers to the inboxes must stop before the services."""
        self._stopping.set()
        for thread in self._threads:
            if thread.is_alive():
                thread.join(5.0)
        for service in self.services:
            service.end()

    def renew(self, lidars: tuple[LidarConfig, ...]) -> None:
        """Replace the lidars."""
        for service in self.services:
            service.renew(lidars)

    def rows(self) -> list[dict[str, Any]]:
        """Every tile."""
        return [row for service in self.services for row in service.rows()]

    def news(self) -> dict[str, Any] | None:
        """News of the current motion, else of the last one that ended."""
        # One chair makes one motion after another: the last to begin is the last to end.
        for service in sorted(self.services, key=lambda one: one.begun_s, reverse=True):
            if (news := service.news()) is not None:
                return news
        return None

    def spot(self) -> dict[str, Any] | None:
        """The chosen spot in the picture, see SpotService.spot."""
        spots = [service.spot() for service in self._spots]
        return next(filter(None, spots), None)

    def choose(self, tile: str, at: At | None, at_s: float) -> bool:
        """As SpotService.choose; discards spots chosen for other kinds."""
        taken = [service for service in self._spots if service.choose(tile, at, at_s)]
        for service in self._spots:
            if taken and service not in taken:
                service.forget()
        return bool(taken)

    def _run(self) -> None:
        pause_s = IDLE_LOOK_S
        while not self._stopping.wait(pause_s):
            if not self._rides:
                self._settings.refresh()  # before a press is seen, which takes what is known
            self._each(ProducerService.tick)
            pause_s = PRESSED_LOOK_S if self._rides else IDLE_LOOK_S

    @property
    def _rides(self) -> bool:
        return any(service.rides for service in self.services)

    def _offer(self) -> None:
        while not self._stopping.wait(_OFFER_S):
            self._each(ProducerService.look)

    def _each(self, act: Callable[[ProducerService], None]) -> None:
        # If one fails, its chair stands, because its process gets no more messages.
        for service in self.services:
            try:
                act(service)
            except Exception:
                self._log.warn("%s", service.health.name, exc_info=True)
