"""The daemon: builds every part of the host from a configuration, and starts and stops them."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from gazechair.alerts.service import Alerts
from gazechair.assist.service import AssistService
from gazechair.base import health as states
from gazechair.base.health import Health, HealthRegistry
from gazechair.base.machine import Machine
from gazechair.base.reasons import (
    CAMERA_FLOOR,
    DEVICES,
    FIRST_DRIVE,
    FORWARD,
    PROFILES,
    SPEED_CAP,
    kind,
)
from gazechair.base.state_folder import state_folder
from gazechair.blackbox.service import BlackBox
from gazechair.board import ports
from gazechair.board.board_commands import Clearance
from gazechair.board.link import BoardLink
from gazechair.board.zone import BoardZone
from gazechair.commissioning.tune.forward_store import ForwardStore
from gazechair.config.settings import Config, LidarConfig, is_loopback, uses_tls
from gazechair.driving.control import Control
from gazechair.driving.speed_cap_store import SpeedCapStore
from gazechair.first_drive.floor_marks import FloorMarks
from gazechair.first_drive.guide import Guide
from gazechair.first_drive.port import FirstDrivePort
from gazechair.first_drive.record import Record
from gazechair.people.profiles import Profiles, house_fields
from gazechair.picture.camera import CameraService
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.newest import LatestPicture
from gazechair.plugins.service import Plugins
from gazechair.producers.places import Places
from gazechair.producers.producers import Producers
from gazechair.producers.service import ProducerService, child_setup
from gazechair.producers.spot_port import SpotPort
from gazechair.producers.spot_service import SpotService
from gazechair.producers.tiles import people, spots
from gazechair.sensing.inbox.feed import Feed
from gazechair.sensing.lidar import LidarService
from gazechair.sensing.mapping.desk import MapDesk
from gazechair.sensing.mapping.service import MappingService
from gazechair.sensing.mapping.stored.store import FOLDER, MapStore
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.service import OdometryService
from gazechair.sensing.odometry.shown import shown

if TYPE_CHECKING:
    from gazechair.web.access import Access

_FAREWELL_S = 0.06  # three repeats of stop and disarm
_STANDS_S = 2.0
_FIRST_S = 3.0  # for the lidars, before everything else is started
_LOOK_S = 0.02

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
        record = Record(folder, self.parts.part(FIRST_DRIVE))
        profiles = Profiles(folder, house_fields(config), self.parts.part(PROFILES))
        lidars = record.masked(config.lidar)
        feed = self._sense(folder, lidars, profiles)
        self._connect(lidars, feed)
        self._drive(folder, profiles)
        self._lead(folder, profiles, record)
        self._access: Access | None = None

    def _sense(self, folder: Path, lidars: tuple[LidarConfig, ...], profiles: Profiles) -> Feed:
        """What works on measurements: log, odometry, map, auto motions, assist; their inboxes."""
        config = self._config
        self._log = BlackBox(
            config.log,
            folder / "log",
            self.parts,
            lambda: self._camera.latest().entry(),
            lidars,
        )
        fitted = tuple(lidar for lidar in lidars if lidar.kind != "off")
        wanted = fitted and config.odometry.measure
        self._odometry = self._measuring(fitted) if wanted else None
        maps = folder / FOLDER
        self._mapping = MappingService(fitted, maps, self.parts.part("map")) if wanted else None
        store = MapStore(maps)
        self._maps = MapDesk(store, self._mapping)
        self._pictures = LatestPicture()
        pictured = config.camera.kind != "off"
        self._floor = FloorStore(folder, self.parts.part(CAMERA_FLOOR) if pictured else None)
        self._producers = Producers(self._driving_itself(fitted, store, profiles, folder))
        self._assist = AssistService(
            fitted,
            config.footprint,
            lambda: self.parts.part("assist"),
            lambda: bool(fitted and profiles.chosen()["assist"]),
        )
        if self._odometry is not None and self._mapping is not None:
            self._odometry.subscribe(self._log.motion)
            self._mapping.subscribe(self._log.pose)
            for service in self._producers.services:
                self._odometry.subscribe(service.estimate)
                self._mapping.subscribe(service.where)
            self._odometry.subscribe(self._mapping.estimate)  # last: each place is an estimate's
        fed = (self._odometry, self._mapping, self._assist, *self._producers.services)
        return Feed(part.inbox_fd for part in fed if part)

    def _connect(self, lidars: tuple[LidarConfig, ...], feed: Feed) -> None:
        """The devices: board, lidars, camera."""
        config = self._config
        self.link = BoardLink(
            ports.finder(config.board.port, ports.BOARD),
            self.parts.part("board"),
            self._changed,
            on_zone=self._zone,
            on_state=feed.board,
            witness=self._log.note,
            traced=config.log.record,
        )
        self._lidar = LidarService(
            lidars,
            config.footprint,
            self._clearance,
            self.parts.part("lidar"),
            self._scan,
            feed.fds,
        )
        self._camera = CameraService(config.camera, self.parts.part("camera"))
        self._camera.subscribe(self._pictures.put)

    def _drive(self, folder: Path, profiles: Profiles) -> None:
        """What leads to a command for the board: pages' requests, plug-ins, auto motions."""
        config = self._config
        self._alerts = Alerts(config, folder, self.parts)
        self.control = Control(
            config,
            self.link,
            self.parts,
            self._camera.latest().age_s,
            profiles=profiles,
            speed_cap=SpeedCapStore(folder, self.parts.part(SPEED_CAP)),
            alerts=self._alerts,
            steer=self._assist.steer,
        )
        self._machine = Machine(self.parts.part("host"), self.control.take_late_s)
        self._plugins = Plugins(config.plugins, self.control, self.parts)
        self._producers.connect(self.control, self.link)
        self.control.show_plugins(lambda: [*self._plugins.rows(), *self._producers.rows()])

    def _lead(self, folder: Path, profiles: Profiles, record: Record) -> None:
        """The first drive."""
        config = self._config
        odometry, forward = self._odometry, ForwardStore(folder, self.parts.part(FORWARD))
        self._guide = Guide(
            config,
            self.link,
            self.parts,
            self.control,
            profiles,
            record,
            self._remask,
            measured=None if odometry is None else odometry.latest.entry,
            keep=forward.keep,
            marks=None
            if config.camera.kind == "off"
            else FloorMarks(self._floor, self._newest_jpeg),
            step_ms=forward.step_ms,
        )

    def _serve(self) -> Access:
        """What people's devices reach: the pages."""
        from gazechair.web import PageParts  # a third of the daemon's imports
        from gazechair.web.access import Access

        port = FirstDrivePort(self.control, self._guide, self._facts)
        parts = PageParts(
            port=SpotPort(port, self.control, self._producers.choose),
            pictures=self._camera.latest(),
            settings=self._guide.settings,
            alerts=self._alerts,
            steps=self._guide,
            maps=self._maps,
        )
        return Access(self._config, parts, self.parts.part(DEVICES))

    @property
    def url(self) -> str:
        """Where the pages are, as other devices reach them."""
        return "" if self._access is None else self._access.url

    @property
    def alive(self) -> bool:
        """False when the thread that passes commands on has stood still for 2 s."""
        return time.monotonic() - self.control.alive_s < _STANDS_S

    def invitation(self) -> str:
        """How to pair the driver's device while there is none, for the terminal; else ""."""
        return "" if self._access is None else self._access.invitation()

    def start(self) -> None:
        """Start every part. Raises gazechair.web.WebError when the page cannot be served.

        Any other part that fails to start is a health state, and the rest continues.
        """
        self._running = True
        web = self._config.web
        if not is_loopback(web.host) and not uses_tls(web):
            log.warning("insecure_http: anyone on this network can listen, and steal a pairing")
        self._maps.tidy()
        if self._config.log.record:
            _start(self._log, self.parts.part("log"))
        self.link.start()
        self.control.start()
        self._machine.start()
        _start(self._lidar, self.parts.part("lidar"))
        try:
            self._access = self._serve()
            self._access.start()
        except Exception:
            self.stop()
            raise
        self._wait_for_lidars()
        _start(self._camera, self.parts.part("camera"))
        if self._odometry is not None:
            _start(self._odometry, self.parts.part("odometry"))
        if self._mapping is not None:
            _start(self._mapping, self.parts.part("map"))
        self._alerts.watch(self.control)
        self._alerts.start()
        self._producers.start(_start)
        self._plugins.start(_start)

    def stop(self) -> None:
        """Stop the chair and disarm it, then end every part, thread and child process."""
        if not self._running:
            return
        self._running = False
        if self._access is not None:
            self._access.stop()
        self._guide.stop()
        self._plugins.stop()
        self._producers.stop()
        self._alerts.stop()
        self._machine.stop()
        self.control.stop()
        time.sleep(_FAREWELL_S)
        self._lidar.stop()
        self._camera.stop()
        self.link.stop()
        # Nothing writes to their inboxes any more.
        for part in (self._odometry, self._mapping, self._assist, *self._producers.services):
            if part is not None:
                part.stop()
        self._log.stop()
        self._pictures.close()

    def _wait_for_lidars(self) -> None:
        """Until they deliver or are lost: a dozen children that start beside theirs would take the
        processors from what the chair needs to drive."""
        health, end_s = self.parts.part("lidar"), time.monotonic() + _FIRST_S
        while health.state == states.STARTING and time.monotonic() < end_s:
            time.sleep(_LOOK_S)

    def _measuring(self, lidars: tuple[LidarConfig, ...]) -> OdometryService:
        obeys = Obeys(self.parts.part("motion"), lambda: self.link.state())
        return OdometryService(lidars, self.parts.part("odometry"), obeys)

    def _driving_itself(
        self, lidars: tuple[LidarConfig, ...], store: MapStore, profiles: Profiles, state: Path
    ) -> list[ProducerService]:
        if self._mapping is None:
            return []
        setup = child_setup(self._config.footprint, store.folder, state)
        floor = self._floor

        def allowed() -> bool:
            return bool(profiles.chosen()["auto"])

        places = Places(store, lambda: (self._maps.where() or {}).get("map", ""), allowed)
        kinds = (
            ("place", "mode places", places),
            ("person", "mode follow-person", lambda: people(allowed())),
        )
        made = [
            ProducerService(kind, lidars, setup, self.parts.part(name), targets)
            for kind, name, targets in kinds
        ]

        pictured = (
            ("look", "mode go-look", lambda: spots("look", allowed(), floor)),
            ("line", "mode follow-line", lambda: spots("line", allowed(), floor)),
        )
        if self._config.camera.kind != "off":
            made += [
                SpotService(
                    *(kind, lidars, setup, self.parts.part(name), targets),
                    pictures=self._pictures.fd,
                )
                for kind, name, targets in pictured
            ]
        return made

    def _remask(self, lidars: tuple[LidarConfig, ...]) -> None:
        self._lidar.renew(lidars)
        fitted = tuple(lidar for lidar in lidars if lidar.kind != "off")
        for part in (self._odometry, self._mapping, self._assist, self._producers):
            if part is not None:
                part.renew(fitted)

    def _changed(self) -> None:
        # Parts report while they are being built too.
        if self._running:
            self.control.update()
            self._guide.look()

    def _newest_jpeg(self) -> bytes | None:
        frame = self._camera.latest().get()
        return None if frame is None else frame.jpeg

    def _facts(self) -> dict[str, object]:
        measured = None if self._odometry is None else self._odometry.latest.entry()
        now_s = time.monotonic()
        return {
            "speed": shown(measured, now_s),
            "where": self._maps.where(),
            "going": self._producers.news(),
            "spot": self._producers.spot(),
            "assist": self._assist.shown(now_s),
        }

    def _zone(self, zone: BoardZone) -> None:
        self._lidar.zone(zone)
        self._assist.zone(zone)

    def _clearance(self, clearance: Clearance) -> None:
        clearance = self._guide.seen(clearance)
        self.control.clearance(clearance)
        self._assist.clearance(clearance)

    def _scan(self, name: str, acquired_s: float, beams: bytes) -> None:
        self._guide.scan(name, acquired_s, beams)
        if self._config.log.record:
            self._log.scan(name, acquired_s, beams)


def _start(part: _Part, health: Health) -> None:
    try:
        part.start()
    except Exception as error:
        log.exception("%s does not start", health.name)
        health.set(states.LOST, f"{kind(health.name)}_lost", f"does not start: {error}")
