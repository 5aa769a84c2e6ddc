"""A chair that is taken to a place, in virtual time: the daemon's parts and the whole firmware.

Where it is in the map is told by the simulator: a double for odometry and mapping, in tests alone.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

import numpy as np

from e2e.host import MASKS
from e2e.lockstep import Lockstep
from gazechair.base import health as states
from gazechair.base.footprint import Footprint
from gazechair.base.health import Health
from gazechair.base.supervisor import Status
from gazechair.config.configuration import FootprintConfig, LidarConfig
from gazechair.picture.newest import Shot
from gazechair.producers.contract import Setup
from gazechair.producers.kinds import build
from gazechair.producers.places import Places, Target
from gazechair.producers.runner import Runner
from gazechair.producers.service import ProducerService, child_setup
from gazechair.sensing.mapping.home_map import HomeMap
from gazechair.sensing.mapping.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.places import Drawn
from gazechair.sensing.mapping.store import MapStore
from gazechair.sensing.mapping.whereabouts import Whereabouts, unpack
from gazechair.sensing.odometry import inbox
from gazechair.sensing.odometry.child import Lidars
from gazechair.sensing.odometry.half_turns import HalfTurns
from gazechair.sensing.odometry.inbox import HalfTurn
from gazechair.sensing.odometry.odometry import Estimate
from gazelink.settings_table import TABLE
from gazesim.rooms import Room
from gazesim.world import TWO

LIDARS = tuple(
    LidarConfig(kind="s2", x_m=x_m, y_m=y_m, heading_deg=heading_deg, mask=MASKS[TWO])
    for x_m, y_m, heading_deg in TWO
)
CELL_M = 0.05
STEP_MS, WHERE_MS, LOOK_MS, OFFER_MS = 50, 100, 250, 250


class Inline(Executor):
    """Thinks at once, in no thread."""

    def submit(self, work: Any, /, *args: Any, **more: Any) -> Future[Any]:
        """Done when this returns."""
        made: Future[Any] = Future()
        try:
            made.set_result(work(*args, **more))
        except Exception as error:
            made.set_exception(error)
        return made


class _Pipe:
    """A child's standard output."""

    def __init__(self) -> None:
        self.newest: bytes | None = None

    def data(self, payload: bytes) -> None:
        """The newest record."""
        self.newest = payload


class Service(ProducerService):
    """Whose child is a runner in this process; `word` is the newest that it was told."""

    word: bytes | None = None

    def _say(self, word: bytes) -> None:
        self.word = word


def stored_map(folder: Path, id_: str, size_m: float, drawn: Drawn) -> None:
    """A square floor without walls in sight, centred at the origin."""
    cells = round(size_m / CELL_M)
    passes = np.full((cells, cells), 9, dtype=np.uint16)
    hits = np.zeros_like(passes)
    hits[[0, -1]] = hits[:, [0, -1]] = 99
    low = np.full(2, -size_m / 2.0)
    folder.mkdir(exist_ok=True)
    HomeMap("Thuis", OccupancyGrid(CELL_M, low, hits, passes), drawn=drawn).save(
        folder / f"{id_}.map"
    )


class GoingChair(Lockstep):
    """Driving is on, its tiles are there; `alive`, `stopped`: the child; `located`: its pose."""

    kind = "place"

    def __init__(self, folder: Path, drawn: Drawn, room: str | Room = "open") -> None:
        super().__init__(room, mounts=TWO)
        stored_map(folder, "home", 12.0, drawn)
        self.store = MapStore(folder)
        self.map = "home"
        self.located = self.looks = self.alive = self.allowed = True
        self.stopped = False
        assert self.host is not None
        setup = child_setup(FootprintConfig(), folder, folder)
        self.health = Health("mode places", self.now_s)
        self.service = self._new_service(self.kind, LIDARS, setup, self.health, self._targets())
        self.settings: dict[str, int] | None = None
        self.service.connect(self.host.control, lambda: self.settings, self._override)
        self._folder = folder
        self._lidars = Lidars(LIDARS)
        for at, stream in enumerate(self.host.streams):
            stream._tap = HalfTurns(at, (self.service.inbox_fd,)).take
        self._truth: deque[tuple[float, float, float, float, float, float]] = deque(maxlen=300)
        self._state_s = 0.0
        self._at: Estimate | None = None
        self.begin_child()
        self.watchers.append(self._daemon)
        self.arm()
        self.settings = {row[0]: getattr(self.board.app.settings, row[0]) for row in TABLE}
        self.until(lambda: not self.board.app.obstacles.blocked & 15, 700)

    def _targets(self) -> Callable[[], Mapping[str, Target]]:
        return Places(self.store, lambda: self.map, lambda: self.allowed, self.now_s)

    def _new_service(self, *parts: Any) -> Service:
        return Service(*parts, self.now_s)

    def _picture(self) -> Shot | None:
        return None

    def _override(self) -> str:
        return str(self.page.shown.get("override", ""))

    def begin_child(self) -> None:
        """Another process."""
        self._pipe = _Pipe()
        setup = Setup(Footprint(), self._folder, self._folder, Inline())
        kind = build(self.kind, setup)
        self._runner = Runner(kind, self._lidars, self._pipe, Inline(), self._picture)
        self.alive, self.stopped = True, False
        self._told: bytes | None = None

    def child_fails(self, how: str = "killed") -> None:
        """Its process is killed, or hangs."""
        if how == "hung":
            self.stopped = True
            return
        self.alive = False
        self.service._on_status(Status(states.LOST, "plugin_lost", "", "ended"))

    def _daemon(self) -> None:
        """Threads and processes round the control: one millisecond."""
        chair, now_s = self.world.chair, self.now_s()
        pose = chair.x_m, chair.y_m, chair.heading_deg, chair.speed_m_s, chair.yaw_rate_deg_s
        self._truth.append((now_s, *pose))
        if self.host is None:
            return
        state = self.host.link.state()
        if state is not None and state.received_s != self._state_s:
            self._state_s = state.received_s
            motion = inbox.Motion(now_s, None, state.linear_permille, state.turn_permille)
            inbox.send(self.service.inbox_fd, inbox.pack_motion(motion))
        if self.now_ms % WHERE_MS == 0 and self.located and self._at is not None:
            at = self._at
            place = at.x_m, at.y_m, at.heading_deg
            where = Whereabouts(at.time_s, self.map, *place, 0.02, 0.3, 0.9, at.time_s)
            self.service.where(where)
        if self.now_ms % OFFER_MS == 0:
            self.service.look()
        if self.now_ms % 4 == 0:
            self.service.tick()
        if not self.alive:
            return
        if self.stopped:
            return
        self._child()
        if self.looks and self.page.alive and self.now_ms % LOOK_MS == 0:
            self.page.look()

    def _child(self) -> None:
        now_s = self.now_s()
        if self.service.word is not self._told and self.service.word is not None:
            self._told = self.service.word
            self._runner.word(json.loads(self._told))
        while True:
            try:
                datagram = self.service._reader.recv(inbox.LONGEST, 64)  # MSG_DONTWAIT
            except BlockingIOError:
                break
            said = unpack(datagram) or inbox.unpack(datagram)
            self._runner.heard(said, now_s)
            if isinstance(said, HalfTurn):
                self._estimate(said, now_s)
        if self.now_ms % STEP_MS == 0:
            self._runner.tick(now_s)
            if self._pipe.newest is not None:
                self.service._on_data(self._pipe.newest)
                self._pipe.newest = None

    def _estimate(self, half: HalfTurn, now_s: float) -> None:
        piece = self._lidars.piece(half)
        if piece is None:
            return
        at_s = piece.middle_s
        _, x, y, heading, speed, rate = min(self._truth, key=lambda row: abs(row[0] - at_s))
        sigmas = (0.0, 0.0, 0.1, 0.02)
        matched, doubts, track = 1.0, (), 1
        self._at = Estimate(at_s, x, y, heading, speed, 0.0, rate, *sigmas, matched, doubts, track)
        self.service.estimate(self._at)

    # -- what is so --

    @property
    def tiles(self) -> dict[str, str]:
        """Mode of each place that can be chosen, by its name."""
        rows = self.service.rows()
        return {row["names"]["nl"]: row["name"] for row in rows if row["state"] == "ok"}

    @property
    def news(self) -> dict[str, Any]:
        """What pages are told of the way."""
        return self.service.news() or {"state": "", "reason": ""}

    def off(self, x_m: float, y_m: float, heading_deg: float) -> tuple[float, float]:
        """Metres and degrees from there, by the truth."""
        chair = self.world.chair
        off_deg = abs(math.remainder(chair.heading_deg - heading_deg, 360.0))
        return math.dist((chair.x_m, chair.y_m), (x_m, y_m)), off_deg
