"""The whole chair in virtual time, driven by a producer: its service, and its child in-process.

A subclass supplies the pose in the map: the simulator's, or that of odometry and mapping.
"""

from __future__ import annotations

import json
import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

from gazeboard.io.settings import FILE, Settings
from gazechair.base.footprint import Footprint
from gazechair.base.health import Health
from gazechair.board.state import BoardState
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.picture.newest import Shot
from gazechair.producers.contract import Setup
from gazechair.producers.kinds import build
from gazechair.producers.places import Places, Target
from gazechair.producers.runner import Runner
from gazechair.producers.service import ProducerService, child_setup
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.half_turns import HalfTurns
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.inbox_service import InboxService
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.mapping.locating.whereabouts import unpack
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import MapStore
from gazelink.settings_table import PROFILES, TABLE
from gazesim.lockstep_chair import Lockstep
from gazesim.lockstep_host import MASKS
from gazesim.rooms import Room
from gazesim.world import TWO

LIDARS = tuple(
    LidarConfig(kind="s2", x_m=x_m, y_m=y_m, heading_deg=heading_deg, mask=MASKS[TWO])
    for x_m, y_m, heading_deg in TWO
)
MAP = "home"
_LOOK_MS, _OFFER_MS = 250, 250

Targets = Callable[[], Mapping[str, Target]]


class Inline(Executor):
    """Computes at once, without a thread."""

    def submit(self, work: Any, /, *args: Any, **more: Any) -> Future[Any]:
        """Run `work`; the future is done when this returns."""
        made: Future[Any] = Future()
        try:
            made.set_result(work(*args, **more))
        except Exception as error:
            made.set_exception(error)
        return made


def waiting(service: InboxService) -> Iterator[bytes]:
    """The datagrams in its inbox."""
    return inbox.waiting(service._reader)


class _Pipe:
    """A child's standard output."""

    def __init__(self) -> None:
        self.newest: bytes | None = None

    def data(self, payload: bytes) -> None:
        """The newest record."""
        self.newest = payload


class Service(ProducerService):
    """A service whose child is a runner in this process; `word` is the newest one sent to it."""

    message: bytes | None = None

    def _send(self, message: bytes) -> None:
        self.message = message


class ProducerChair(Lockstep, ABC):
    """An armed chair with the producer's tiles.

    `alive`, `stopped`: state of the child; `allowed`: the driver may use auto motions; `looks`: the
    driver looks at the page.
    """

    kind = "place"

    def __init__(
        self, folder: Path, home: HomeMap, room: str | Room = "open", profile: str = ""
    ) -> None:
        """`folder`: for the map; `profile`: of chair and board, at full deflection; "": as set."""
        super().__init__(room, mounts=TWO)
        if profile:
            self._select(profile)
        folder.mkdir(exist_ok=True)
        home.save(folder / f"{MAP}.map")
        self.store = MapStore(folder)
        self.map = MAP
        self.looks = self.alive = self.allowed = True
        self.stopped = False
        assert self.host is not None
        setup = child_setup(FootprintConfig(), folder, folder)
        self.health = Health("mode places", self.now_s)
        self.service = self._new_service(setup, self.health, self._targets())
        self.settings: dict[str, int] | None = None
        self.service.connect(self.host.control, lambda: self.settings, self._override)
        self._folder = folder
        self._lidars = Lidars(LIDARS)
        for at, stream in enumerate(self.host.streams):
            stream._tap = HalfTurns(at, (self.service.inbox_fd, *self._inboxes())).take
        self._state_s = 0.0
        self.begin_child()
        self.watchers.append(self._daemon)
        self.arm()
        self.settings = {row[0]: getattr(self.board.app.settings, row[0]) for row in TABLE}

    def _select(self, profile: str) -> None:
        stored = Settings()
        for name, value in (
            ("profile", PROFILES.index(profile)),
            ("linear_permille", 1000),
            ("turn_permille", 1000),
        ):
            stored.set([row[0] for row in TABLE].index(name), value)
        self.board.files.store(FILE, stored.text())
        self.board.reset()
        self.world.chair.set_profile(profile)

    def _inboxes(self) -> tuple[int, ...]:
        """Inboxes besides the producer's that get the lidars' half turns."""
        return ()

    def _targets(self) -> Targets:
        return Places(self.store, lambda: self.map, lambda: self.allowed, self.now_s)

    def _new_service(self, setup: Mapping[str, Any], health: Health, targets: Targets) -> Service:
        return Service(self.kind, LIDARS, setup, health, targets, self.now_s)

    def _picture(self) -> Shot | None:
        return None

    def _thinker(self) -> Executor:
        """The executor that plans."""
        return Inline()

    def _override(self) -> str:
        state = None if self.host is None else self.host.link.state()
        return "" if state is None else str(state.override_name)

    def begin_child(self) -> None:
        """Start a new child."""
        self._pipe = _Pipe()
        setup = Setup(Footprint(), self._folder, self._folder, self._thinker())
        kind = build(self.kind, setup)
        self._runner = Runner(kind, self._lidars, self._pipe, Inline(), self.now_s, self._picture)
        self.alive, self.stopped = True, False
        self._sent: bytes | None = None

    def _daemon(self) -> None:
        """One millisecond of the threads and processes around Control."""
        if self.host is None:
            return
        state = self.host.link.state()
        if state is not None and state.received_s != self._state_s:
            self._state_s = state.received_s
            self._board_says(state)
        self._locate()
        if self.now_ms % _OFFER_MS == 0:
            self.service.look()
        if self.now_ms % 4 == 0:
            self.service.tick()
        if not self.alive or self.stopped:
            return
        self._child()
        if self.looks and self.page.alive and self.now_ms % _LOOK_MS == 0:
            self.page.look()

    def _board_says(self, state: BoardState) -> None:
        motion = Motion(self.now_s(), None, state.linear_permille, state.turn_permille)
        inbox.send(self.service.inbox_fd, inbox.pack_motion(motion))

    @abstractmethod
    def _locate(self) -> None:
        """Called every millisecond: give the service the chair's pose."""

    def _half_turn(self, half: HalfTurn) -> None:
        """Called when the child has received half a turn."""

    def _child(self) -> None:
        now_s = self.now_s()
        if self.service.message is not self._sent and self.service.message is not None:
            self._sent = self.service.message
            self._runner.on_message(json.loads(self._sent))
        for datagram in waiting(self.service):
            data = unpack(datagram) or inbox.unpack(datagram)
            self._runner.received(data, now_s)
            if isinstance(data, HalfTurn):
                self._half_turn(data)
        if not self._runner.left_s(now_s):
            self._runner.tick(now_s)
            if self._pipe.newest is not None:
                self.service._on_data(self._pipe.newest)
                self._pipe.newest = None

    # -- state --

    @property
    def tiles(self) -> dict[str, str]:
        """Mode of each place that can be chosen, by its name."""
        rows = self.service.rows()
        return {row["names"]["nl"]: row["name"] for row in rows if row["state"] == "ok"}

    @property
    def news(self) -> dict[str, Any]:
        """News of the motion, as sent to pages."""
        return self.service.news() or {"state": "", "reason": ""}

    def off(self, x_m: float, y_m: float, heading_deg: float) -> tuple[float, float]:
        """Distance, m, and angle, degrees, of the chair's true pose to the given one."""
        chair = self.world.chair
        off_deg = abs(math.remainder(chair.heading_deg - heading_deg, 360.0))
        return math.dist((chair.x_m, chair.y_m), (x_m, y_m)), off_deg
