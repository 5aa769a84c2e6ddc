"""The daemon: builds every part of the host from a configuration, and starts and stops them."""

from __future__ import annotations

import logging
import time
from typing import Protocol

from gazechair.alerts.service import Alerts
from gazechair.base import health as h
from gazechair.base.health import Health, HealthRegistry
from gazechair.base.machine import Machine
from gazechair.base.reasons import kind
from gazechair.base.state_folder import state_folder
from gazechair.blackbox.recorder import BlackBox
from gazechair.board import ports
from gazechair.board.caretaker_settings import CaretakerSettings
from gazechair.board.link import BoardLink
from gazechair.config.configuration import Config, is_loopback, uses_tls
from gazechair.driving.control import Control
from gazechair.driving.speed_cap_store import KeptCap
from gazechair.first_drive.guide import Guide
from gazechair.first_drive.port import FirstDrivePort
from gazechair.first_drive.record import Record
from gazechair.people.profiles import Profiles, house_fields
from gazechair.picture.camera import CameraService
from gazechair.plugins.service import Plugins
from gazechair.sensing.lidar import LidarService
from gazechair.web.access import FrontDoor

_LAST_WORDS_S = 0.06  # three repeats of stop and disarm
_STANDS_S = 2.0

log = logging.getLogger(__name__)


class _Part(Protocol):
    def start(self) -> None: ...
    def stop(self) -> None: ...


class Daemon:
    """The whole host in one process; lidar, camera, log and each plug-in add a child process."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._running = False
        self.parts = HealthRegistry(on_change=self._changed)
        folder = state_folder(config.web.state_folder)
        record = Record(folder)
        lidars = record.masked(config.lidar)
        self._log = BlackBox(
            config.log,
            folder / "log",
            self.parts,
            lambda: self._camera.latest().entry(),
            lidars,
        )
        self.link = BoardLink(
            ports.finder(config.board.port, ports.BOARD),
            self.parts.part("board"),
            self._changed,
            on_zone=lambda zone: self._lidar.zone(zone),
            witness=self._log.note,
            traced=config.log.record,
        )
        self._lidar = LidarService(
            lidars,
            config.footprint,
            lambda clearance: self.control.clearance(self._guide.seen(clearance)),
            self.parts.part("lidar"),
            self._scan,
        )
        self._camera = CameraService(config.camera, self.parts.part("camera"))
        self._alerts = Alerts(config, folder, self.parts)
        profiles = Profiles(folder, house_fields(config))
        self.control = Control(
            config,
            self.link,
            self.parts,
            self._camera.latest().age_s,
            profiles=profiles,
            kept_cap=KeptCap(folder),
            alerts=self._alerts,
        )
        self._machine = Machine(self.parts.part("host"), self.control.take_late_s)
        self._plugins = Plugins(config.plugins, self.control, self.parts)
        self._guide = Guide(
            config, self.link, self.parts, self.control, profiles, record, self._lidar.renew
        )
        self._web = FrontDoor(
            config,
            FirstDrivePort(self.control, self._guide),
            self._camera.latest(),
            CaretakerSettings(self.link),
            self._alerts,
            self._guide,
        )

    @property
    def url(self) -> str:
        """Where the pages are, as other devices reach them."""
        return self._web.url

    @property
    def alive(self) -> bool:
        """False when the thread that passes commands on has stood still for 2 s."""
        return time.monotonic() - self.control.alive_s < _STANDS_S

    def invitation(self) -> str:
        """How to pair the driver's device while there is none, for the terminal; else ""."""
        return self._web.invitation()

    def start(self) -> None:
        """Start every part. Raises gazechair.web.WebError when the page cannot be served.

        Any other part that fails to start is a health state, and the rest continues.
        """
        self._running = True
        web = self._config.web
        if not is_loopback(web.host) and not uses_tls(web):
            log.warning("insecure_http: anyone on this network can listen, and steal a pairing")
        try:
            self._web.start()
        except Exception:
            self.stop()
            raise
        if self._config.log.record:
            _start(self._log, self.parts.part("log"))
        self.link.start()
        self.control.start()
        self._machine.start()
        for part, health in (
            (self._lidar, self.parts.part("lidar")),
            (self._camera, self.parts.part("camera")),
        ):
            _start(part, health)
        self._alerts.watch(self.control)
        self._alerts.start()
        self._plugins.start(_start)

    def stop(self) -> None:
        """Stop the chair and disarm it, then end every part, thread and child process."""
        if not self._running:
            return
        self._running = False
        self._web.stop()
        self._guide.stop()
        self._plugins.stop()
        self._alerts.stop()
        self._machine.stop()
        self.control.stop()
        time.sleep(_LAST_WORDS_S)
        self._lidar.stop()
        self._camera.stop()
        self.link.stop()
        self._log.stop()

    def _changed(self) -> None:
        # Parts report while they are being built too.
        if self._running:
            self.control.update()
            self._guide.look()

    def _scan(self, name: str, acquired_s: float, beams: bytes) -> None:
        self._guide.scan(name, acquired_s, beams)
        if self._config.log.record:
            self._log.scan(name, acquired_s, beams)


def _start(part: _Part, health: Health) -> None:
    try:
        part.start()
    except Exception as error:
        log.exception("%s does not start", health.name)
        health.set(h.LOST, f"{kind(health.name)}_lost", f"does not start: {error}")
