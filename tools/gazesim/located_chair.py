"""A chair that locates itself by the real odometry and mapping, as their processes do it.

Their computing takes virtual time, too: results arrive that much later.
"""

from __future__ import annotations

import json
import math
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from gazechair.base.health import Health
from gazechair.board.state import BoardState
from gazechair.going.mission import Mission
from gazechair.producers.places import Places
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.feed import Feed
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.mapping.service import MappingService
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.worker import Worker
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.service import OdometryService
from gazesim.producer_chair import LIDARS, MAP, ProducerChair, Targets, waiting
from gazesim.rooms import Room
from gazesim.thinker import PLAN_MS, Thinker

_ODOMETRY_MS, _MAPPING_MS = 15, 60
_TICK_MS = 500
_CHUNK_S = 0.01  # of the lidars' data: longer than usual, for half as many ray casts
_PLACE_OLD_S = 1.0


class _Out:
    """Takes the reports of mapping's process."""

    def __init__(self, data: Callable[[bytes], None]) -> None:
        self.data = data

    def facts(self, payload: bytes) -> None:
        """Ignores pictures and finished maps."""


class LocatedChair(ProducerChair):
    """A chair that never receives its pose."""

    def __init__(
        self,
        folder: Path,
        home: HomeMap,
        room: Room,
        profile: str = "",
        plan_ms: float | None = PLAN_MS,
    ) -> None:
        """`plan_ms`: time that a plan takes; None: its own CPU time."""
        self._plan_ms = plan_ms
        self.now_ms, now_s = 0, self.now_s
        obeys = Obeys(Health("motion", now_s), lambda: None)
        self.odometry = OdometryService(LIDARS, Health("odometry", now_s), obeys)
        self.mapping = MappingService(LIDARS, folder, Health("map", now_s))
        self._odometry, self._pieces = Odometry(1), Lidars(LIDARS)
        out = _Out(lambda payload: self._later(_MAPPING_MS, self.mapping._on_data, payload))
        self._coming: deque[tuple[int, Callable[[bytes], None], bytes]] = deque()
        self._worker = Worker(Lidars(LIDARS), folder, out, now_s)
        super().__init__(folder, home, room, profile)
        for lidar in self.world.lidars:
            lidar._chunk_s = _CHUNK_S

    def _new_service(self, setup: Any, health: Health, targets: Targets) -> Any:
        service = super()._new_service(setup, health, targets)
        self.odometry.subscribe(service.estimate)
        self.mapping.subscribe(service.where)
        self.odometry.subscribe(self.mapping.estimate)  # last: each pose belongs to an estimate
        self._feed = Feed((service.inbox_fd, *self._inboxes()))
        return service

    def _inboxes(self) -> tuple[int, ...]:
        return self.odometry.inbox_fd, self.mapping.inbox_fd

    def _targets(self) -> Targets:
        return Places(self.store, self._here, lambda: self.allowed, self.now_s)

    def _here(self) -> str:
        entry = self.mapping.latest.entry()
        if entry is None or self.now_s() - entry.born_s > _PLACE_OLD_S:
            return ""
        return entry.value.map

    @property
    def known(self) -> bool:
        """True if the chair knows its pose in a map."""
        return bool(self._here())

    @property
    def mission(self) -> Mission | None:
        """The newest mission to a place; None: it is not made yet."""
        made = self._runner._producer._mission  # type: ignore[attr-defined]
        return made.result() if made.done() and not made.cancelled() else None

    def came_here(self) -> None:
        """Give it its true pose, as if known from the drive that brought it here."""
        chair, looks = self.world.chair, self._worker._looks
        self.until(lambda: self._worker._newest is not None and bool(self._worker._atlas.ids), 1500)
        pose = np.array((chair.x_m, chair.y_m, math.radians(chair.heading_deg)))
        self._worker._atlas.place(MAP, pose, looks.pose, looks.track)

    def close(self) -> None:
        """Close its inboxes; it is unusable afterwards."""
        for service in (self.odometry, self.mapping, self.service):
            service.stop()

    def _thinker(self) -> Executor:
        return Thinker(self.now_s, self._plan_ms)

    def _board_says(self, state: BoardState) -> None:
        self._feed.board(state)

    def _later(self, ms: int, receive: Callable[[bytes], None], payload: bytes) -> None:
        self._coming.append((self.now_ms + ms, receive, payload))

    def _locate(self) -> None:
        for datagram in waiting(self.odometry):
            data = inbox.unpack(datagram)
            if isinstance(data, Motion):
                self._odometry.motion(data)
            elif isinstance(data, HalfTurn):
                piece = self._pieces.piece(data)
                estimate = self._odometry.piece(piece) if piece is not None else None
                if estimate is not None:
                    payload = json.dumps(asdict(estimate)).encode()
                    self._later(_ODOMETRY_MS, self.odometry._on_data, payload)
        for datagram in waiting(self.mapping):
            data = inbox.unpack(datagram)
            if isinstance(data, HalfTurn):
                self._worker.half(data)
            elif isinstance(data, Estimate):
                self._worker.estimate(data)
        if self.now_ms % _TICK_MS == 0:
            self._worker.tick()
        due = [one for one in self._coming if one[0] <= self.now_ms]
        for one in due:
            self._coming.remove(one)
            one[1](one[2])
