"""A chair with a calibrated camera over a drawn floor, in virtual time: for who chooses a spot."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from e2e.going_chair import GoingChair
from gazechair.base.health import Health
from gazechair.picture.floor import FloorCamera
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.newest import LatestPicture, PictureReader, Shot
from gazechair.producers.spot_port import SpotPort
from gazechair.producers.spot_service import SpotService
from gazechair.sensing.mapping.stored.places import Drawn
from gazesim.floor_view import Eye, Floor, FloorView
from gazesim.producer_chair import LIDARS, Service, Targets
from gazesim.rooms import Room

EYE = Eye(field_deg=75.0, height_m=1.15, down_deg=30.0)
CAMERA = FloorCamera(
    320, 240, 160.0 / math.tan(math.radians(37.5)), 1.15, math.radians(30.0), x_m=0.3
)
PICTURE_MS = 100


class SpotServiceHere(SpotService, Service):
    """Whose child is a runner in this process."""


class PictureChair(GoingChair):
    """`sees`: the camera works; `late_ms`: of its pictures."""

    tile = ""
    late_ms = 60

    def __init__(self, folder: Path, floor: Floor, room: str | Room = "open") -> None:
        self.floor = FloorStore(folder)
        self.floor.keep(Calibration(CAMERA, 0.01, 0.01))
        self.view = FloorView(EYE, floor, 3)
        self.sees = True
        self._slot = LatestPicture()
        self._coming: list[tuple[int, Shot]] = []
        super().__init__(folder, Drawn(), room)
        assert self.host is not None
        control = self.host.control
        self.host.port = SpotPort(control, control, self.service.choose)
        self.watchers.append(self._camera)
        self.until(lambda: self.tile in [row["name"] for row in self.service.rows()], 600)

    def _new_service(
        self, setup: Mapping[str, Any], health: Health, targets: Targets
    ) -> SpotServiceHere:
        self.service = SpotServiceHere(self.kind, LIDARS, setup, health, targets, self.now_s)
        return self.service

    def begin_child(self) -> None:
        self._reader = PictureReader(self._slot.fd)
        super().begin_child()

    def _picture(self) -> Shot | None:
        return self._reader.take()

    def _camera(self) -> None:
        if self.sees and self.now_ms % PICTURE_MS == 0:
            chair = self.world.chair
            jpeg = self.view.jpeg(chair.x_m, chair.y_m, chair.heading_deg)
            self._coming.append((self.now_ms + self.late_ms, Shot(jpeg, self.now_s())))
        while self._coming and self._coming[0][0] <= self.now_ms:
            shot = self._coming.pop(0)[1]
            self._slot.put(shot.jpeg, shot.acquired_s)

    def looks_at(self, x_m: float, y_m: float) -> None:
        """Dwell on a floor spot, in metres from where the chair began."""
        chair = self.world.chair
        turn = math.radians(chair.heading_deg)
        dx, dy = x_m - chair.x_m, y_m - chair.y_m
        ahead = math.cos(turn) * dx + math.sin(turn) * dy
        left = math.cos(turn) * dy - math.sin(turn) * dx
        u, v = EYE.pixel(ahead, left)
        self.page.spot(self.tile, (u / EYE.width_px, v / EYE.height_px))

    @property
    def spot(self) -> dict[str, Any]:
        """What pages are told of it."""
        return self.service.spot() or {"state": "", "reason": "", "mode": ""}

    def go(self) -> None:
        """Dwell on *Ga*."""
        self.page.choose(self.spot["mode"])
