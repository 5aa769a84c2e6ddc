"""A kind that needs the picture, as a real process: its pictures and its output."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from e2e.picture_chair import CAMERA, EYE
from gazechair.base.health import Health
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.driving.mode_context import ModeContext
from gazechair.picture.floor_calibration import Calibration
from gazechair.picture.floor_store import FloorStore
from gazechair.picture.newest import LatestPicture
from gazechair.producers.service import child_setup
from gazechair.producers.spot_service import SpotService
from gazechair.producers.tiles import spots
from gazechair.sensing.odometry.estimate import Estimate
from gazelink.settings_table import TABLE
from gazesim.floor_view import Floor, FloorView
from patience import wait_until

TAPE = np.array(((0.8, 0.0), (4.0, 0.0)))
SEES = dict.fromkeys(("forward", "backward", "left", "right"), "seen")


class Port:
    """The port of an armed, standing chair; `offered`: modes that can be pressed."""

    def __init__(self) -> None:
        self.offered: set[str] = set()

    def offer_mode(self, mode: str, tile: dict[str, Any] | None) -> None:
        (self.offered.discard if tile is None else self.offered.add)(mode)

    def mode_context(self) -> ModeContext:
        return ModeContext("", 0, time.monotonic(), True, 0.0, 0.0, dict.fromkeys(SEES), SEES)


class Chair:
    """Fed by hand, in real time."""

    def __init__(self, folder: Path) -> None:
        store = FloorStore(folder)
        store.keep(Calibration(CAMERA, 0.01, 0.01))
        self.slot, self.port = LatestPicture(), Port()
        self.jpeg = FloorView(EYE, Floor(lines=[TAPE]), 3).jpeg(0.0, 0.0, 0.0)
        setup = child_setup(FootprintConfig(), folder / "maps", folder)
        lidars = (LidarConfig(kind="s2", port="/nowhere"),)
        self.service = SpotService(
            *("line", lidars, setup, Health("mode follow-line")),
            lambda: spots("line", True, store),
            pictures=self.slot.fd,
        )
        self.service.connect(self.port, lambda: {row[0]: row[1] for row in TABLE}, lambda: "")  # type: ignore[arg-type]
        self.service.start()

    def feed(self) -> None:
        """Send an estimate and a picture, and tick the service."""
        now_s = time.monotonic()
        still = (0.0,) * 10
        self.service.estimate(Estimate(now_s, *still, 1.0, (), 1))
        self.slot.put(self.jpeg, now_s)
        self.service.look()
        self.service.tick()

    def chosen(self) -> bool:
        """Look at the tape again and again, until it can be pressed."""
        self.feed()
        spot = self.service.spot()
        if spot is None or spot["state"] == "ended":
            u, v = EYE.pixel(1.7, 0.0)
            at = u / EYE.width_px, v / EYE.height_px
            self.service.choose("follow-line", at, time.monotonic())
        return bool(self.port.offered)

    def pid(self) -> int:
        assert self.service._supervisor is not None
        process = self.service._supervisor._process
        assert process is not None
        return process.pid


@pytest.fixture
def chair(tmp_path: Path) -> Iterator[Chair]:
    made = Chair(tmp_path)
    yield made
    made.service.stop()
    made.slot.close()


def test_sees_the_line_shows_it_and_forgets_it_with_its_process(chair: Chair) -> None:
    wait_until(chair.chosen, "the line")
    spot = chair.service.spot()
    assert spot is not None
    assert spot["mode"] in chair.port.offered
    assert len(spot["px"]) > 5
    os.kill(chair.pid(), signal.SIGKILL)
    wait_until(lambda: chair.service.spot() is None, "the end of its process")
    assert not chair.port.offered
    wait_until(chair.chosen, "another process")
