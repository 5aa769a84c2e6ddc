"""The doctor's device checks: starts the real parts briefly and reads their health."""

from __future__ import annotations

import time
from dataclasses import replace

from gazechair.base import health as h
from gazechair.base.health import HealthRegistry, HealthState
from gazechair.board import ports
from gazechair.board.link import BoardLink
from gazechair.config.configuration import Config
from gazechair.picture.camera import CameraService
from gazechair.sensing.lidar import LidarService

PATIENCE_S = 8.0
_SETTLED_S = 1.0


def ask(config: Config) -> dict[str, HealthState]:
    """{part: its health after a while} of board, lidar and camera. Nothing is armed or moved.

    Takes up to 8 s when a part does not answer; a part used by a running daemon reports that.
    """
    registry = HealthRegistry()
    link = BoardLink(ports.finder(config.board.port, ports.BOARD), registry.part("board"))
    lidar = LidarService(config.lidar, config.footprint, lambda _: None, registry.part("lidar"))
    camera = CameraService(config.camera, registry.part("camera"))
    try:
        for part in (link, lidar, camera):
            part.start()
        deadline_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline_s and not _settled(registry):
            time.sleep(0.05)
        answers = registry.states()
        answers["board"] = _introduced(link, answers["board"])
        if answers["lidar"].state == h.OK:
            answers["lidar"] = replace(answers["lidar"], detail=lidar.describe())
    finally:
        for part in (camera, lidar, link):
            part.stop()
    return answers


def _settled(registry: HealthRegistry) -> bool:
    now_s = time.monotonic()
    return all(
        state.state == h.OK or (state.state == h.LOST and now_s - state.since_s > _SETTLED_S)
        for state in registry.states().values()
    )


def _introduced(link: BoardLink, answer: HealthState) -> HealthState:
    board = link.board()
    if answer.state != h.OK or board is None:
        return answer
    round_trip_s = link.ping()
    took = "no answer to a ping" if round_trip_s is None else f"{round_trip_s * 1000:.1f} ms"
    kind = "simulated, " if board.simulated else ""
    detail = f"{board.name} {board.version}, {kind}round trip {took}"
    return HealthState(answer.state, answer.reason, detail, answer.since_s)
