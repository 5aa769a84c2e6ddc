"""Mapping's worker fed by a drive through a home, in virtual time."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars, Piece
from gazechair.sensing.mapping.worker import PULSE_S, Worker
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.odometry import Odometry
from gazesim import home_plans
from gazesim.home_drive import FRONT, Drive

START_S = 1000.0
PER_TURN = 400  # measurements: fewer than a lidar makes, for speed


class Told:
    """What the worker reports."""

    def __init__(self) -> None:
        self.newest: dict[str, Any] = {}
        self.ended: list[dict[str, Any]] = []
        self.pictures: list[tuple[dict[str, Any], bytes]] = []

    def data(self, payload: bytes) -> None:
        self.newest = json.loads(payload)

    def facts(self, payload: bytes) -> None:
        line, _, rest = payload.partition(b"\n")
        fields = json.loads(line)
        if "ended" in fields:
            self.ended.append(fields["ended"])
        else:
            self.pictures.append((fields["picture"], rest))


class Chair:
    """A chair in a home, its odometry, and the worker."""

    def __init__(self, folder: Path, home: int, seed: int, start_s: float = START_S) -> None:
        self.folder = folder
        self.told = Told()
        self.now_s = start_s
        self.words = 0
        self.drive = Drive(home_plans.home(home), seed, (FRONT,), PER_TURN)
        self.odometry = Odometry()
        self.track = 0
        lidars = Lidars((LidarConfig(kind="s2", x_m=FRONT.x_m),))
        self.worker = Worker(lidars, folder, self.told, lambda: self.now_s)
        self._start_s = start_s
        self._tick_s = 0.0
        self._events = self.drive.events(3600.0)

    def word(self, do: str, **more: str) -> None:
        self.words += 1
        self.worker.word({"n": self.words, "do": do, **more})

    def go(self, seconds: float, look: Callable[[Estimate], None] = lambda _: None) -> None:
        """Drive; `look` at each estimate, in the time of the drive."""
        end_s = self.now_s + seconds
        for event in self._events:
            self.now_s = self._start_s + self.drive.time_s
            if self.now_s >= self._tick_s:
                self._tick_s = self.now_s + PULSE_S
                self.worker.tick()
            if self.now_s >= end_s:
                return
            if isinstance(event, Motion):
                self.odometry.motion(event)
                continue
            said = inbox.unpack(inbox.pack_scan(self._half(event)))
            estimate = self.odometry.piece(event)
            assert isinstance(said, HalfTurn)
            self.worker.half(said)
            if estimate is not None:
                look(estimate)
                self.worker.estimate(self._estimate(estimate))

    def until(self, condition: Callable[[], bool]) -> None:
        """Tick without driving, so that a thread of the worker can run."""
        while not condition():
            self.worker.tick()
            time.sleep(0.001)  # otherwise that thread gets the interpreter only every 5 ms

    def _half(self, piece: Piece) -> HalfTurn:
        times = self._start_s + piece.times_s
        return HalfTurn(0, piece.directions_deg, piece.distances_m, times[0], times[-1])

    def _estimate(self, estimate: Estimate) -> Estimate:
        fields = {**vars(estimate), "time_s": self._start_s + estimate.time_s}
        fields["track"] += self.track
        said = inbox.unpack(inbox.pack_estimate(Estimate(**fields)))
        assert isinstance(said, Estimate)
        return said


def made(folder: Path, home: int, name: str, seconds: float) -> Chair:
    """A chair that has driven through a home for a time and stored its map."""
    chair = Chair(folder, home, home)
    chair.word("make")
    chair.go(seconds)
    chair.word("save", path=str(folder / f"{name}.map"), name=f"home {name}")
    chair.until(lambda: bool(chair.told.ended))
    return chair
