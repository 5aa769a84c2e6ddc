"""The doctor's device checks: starts the real parts briefly and reads their health."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from gazechair.base import health as states
from gazechair.base.health import HealthRegistry, HealthState
from gazechair.base.languages import message
from gazechair.board import ports
from gazechair.board.link import BoardLink
from gazechair.config.settings import Config
from gazechair.picture.camera import CameraService
from gazechair.sensing.lidar import LidarService
from gazelink import codes

PATIENCE_S = 8.0
_SETTLED_S = 1.0
_POLL_S = 0.05

# Of any board in a new session of the doctor, which sends no obstacle data.
_NO_HOST = (codes.HOST_SILENT, codes.OBSTACLE_DATA_OLD)


def ask(config: Config) -> dict[str, HealthState]:
    """{part: its health after a while} of board, lidar, camera, and the board's faults ("board
    fault NAME"). Nothing is armed or moved.

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
            time.sleep(_POLL_S)
        answers = registry.states()
        answers["board"] = _introduced(link, answers["board"])
        answers |= _faults(link)
        if answers["lidar"].state == states.OK:
            answers["lidar"] = replace(answers["lidar"], detail=lidar.describe())
    finally:
        for part in (camera, lidar, link):
            part.stop()
    return answers


def _settled(registry: HealthRegistry) -> bool:
    now_s = time.monotonic()
    return all(
        state.state == states.OK
        or (state.state == states.LOST and now_s - state.since_s > _SETTLED_S)
        for state in registry.states().values()
    )


def _introduced(link: BoardLink, answer: HealthState) -> HealthState:
    board = link.board()
    if answer.state != states.OK or board is None:
        return answer
    round_trip_s = link.ping()
    took = "no answer to a ping" if round_trip_s is None else f"{round_trip_s * 1000:.1f} ms"
    kind = "simulated, " if board.simulated else ""
    detail = f"{board.name} {board.version}, {kind}round trip {took}"
    return HealthState(answer.state, answer.reason, detail, answer.since_s)


def _faults(link: BoardLink) -> Iterator[tuple[str, HealthState]]:
    """The faults that the board reports, active and latched, if it is connected."""
    end_s = time.monotonic() + _SETTLED_S  # the session may have just begun
    while (state := link.state()) is None:
        if link.board() is None or time.monotonic() > end_s:
            return
        time.sleep(_POLL_S)
    for bit, name, severity, _latched in codes.FAULTS:
        if state.faults >> bit & 1 and bit not in _NO_HOST:
            level = states.LOST if severity == codes.ERROR else states.DEGRADED
            detail = " ".join(message("en", name))
            yield f"board fault {name}", HealthState(level, name, detail, state.received_s)
