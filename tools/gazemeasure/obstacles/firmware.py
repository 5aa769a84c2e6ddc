"""Runs past obstacles through the whole firmware in virtual time: lidar bytes to wipers."""

from __future__ import annotations

import math

from gazechair.base.footprint import Footprint
from gazechair.board.board_commands import Clearance
from gazechair.board.zone import BoardZone
from gazechair.sensing.clearance.evaluate import Evaluator
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazechair.sensing.lidar import zone_message
from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import to_chair
from gazechair.sensing.lidar.stream import ByteStream
from gazelink import codes
from gazelink.settings_table import PROFILES
from gazemeasure.obstacles.eyes import FRONT
from gazemeasure.obstacles.run import MOVING_M_S, Outcome, fastest
from gazesim.chair_rig import LinkedChair
from gazesim.random_rooms import Task, task
from gazesim.rooms import Room

_LIMIT_MS = 25_000
_GATHER_MS = 5
_LATE_MS = 3  # evaluation and line
_CHECK_MS = 20
DENSE = b"\xa5\x82\x05\x01\x00\x00\x00\x00\x23"
_MOUNT = FRONT[0]
_KINDS = ("door", "way", "room")


class Eyes:
    """The lidar's part of the host: bytes in, clearance out, renewed each quarter turn."""

    def __init__(self, zone: StopZone = UNKNOWN, gather_ms: int = _GATHER_MS) -> None:
        """`gather_ms`: interval at which bytes are processed."""
        self._gather_ms = gather_ms
        self._stream = ByteStream("dense", codes.SIMULATED)
        self._blindness = Blindness()
        self._evaluate = Evaluator(Footprint(), [(_MOUNT.pose.x_m, _MOUNT.pose.y_m)])
        self._evaluate.zone = zone
        self._bytes = bytearray()

    def receive(self, zone: BoardZone) -> None:
        """New stopping distances of the board."""
        self._evaluate.zone = zone_message.unpack(zone_message.pack(zone))

    def step(self, data: bytes, now_ms: int) -> Clearance | None:
        """Process a millisecond's bytes; returns the new clearance, if any."""
        self._bytes += data
        if now_ms % self._gather_ms or not self._bytes:
            return None
        fed, self._bytes = bytes(self._bytes), bytearray()
        if not self._stream.feed(fed, now_ms / 1000.0):
            return None
        scan = self._stream.scan()
        if scan is None:
            return None
        view = to_chair(scan, _MOUNT.pose, _MOUNT.mask, self._blindness)
        return Clearance(source=scan.source, acquired_s=scan.acquired_s, **self._evaluate((view,)))


class SeeingChair(LinkedChair):
    """A chair whose host gets clearances from the lidar, some ms late."""

    def __init__(self, room: Room, profile: str) -> None:
        super().__init__(room, profile)
        self.owner = codes.DRIVER
        self.sees = False
        self.world.lidar.receive(DENSE)
        self._eyes = Eyes(StopZone(self.app.obstacles.zone))
        self._pending: list[tuple[int, Clearance]] = []

    def one_ms(self) -> None:
        """One step, and the clearance from its scan."""
        super().one_ms()
        clearance = self._eyes.step(self.scanned, self.now_ms)
        if clearance is not None:
            self._pending.append((self.now_ms + _LATE_MS, clearance))
        if self._pending and self._pending[0][0] <= self.now_ms:
            self.link.clearance(self._pending.pop(0)[1])


def firmware_run(seed: int) -> Outcome:
    """One run forward, with the prototype's one lidar, at the board's own settings."""
    profile = PROFILES[seed % len(PROFILES)]
    wanted = _forward(_KINDS[seed % len(_KINDS)], seed)
    chair, outcome = SeeingChair(wanted.room, profile), Outcome()
    chair.arm()
    chair.run(300)
    start_m = (chair.world.chair.x_m, chair.world.chair.y_m)
    begun_ms = chair.now_ms
    chair.press(codes.FORWARD, codes.CONTINUOUS)
    while chair.now_ms < begun_ms + _LIMIT_MS:
        chair.one_ms()
        truth = chair.world.chair
        if chair.now_ms % _CHECK_MS == 0:
            gap_m = wanted.room.clearance_m(truth.x_m, truth.y_m, truth.heading_deg)
            if fastest(truth) > MOVING_M_S:
                outcome.least_m = min(outcome.least_m, gap_m)
        if chair.world.collisions:
            outcome.touched = outcome.collided = True
            break
        if math.hypot(truth.x_m - start_m[0], truth.y_m - start_m[1]) >= wanted.goal:
            outcome.arrived = True
            break
        if chair.now_ms > begun_ms + 300 and fastest(truth) == 0.0:
            outcome.stopped = True
            break
    outcome.took_s = (chair.now_ms - begun_ms) / 1000.0
    return outcome


def _forward(kind: str, seed: int) -> Task:
    """The task of that kind and seed, or of the next seed whose motion is forward."""
    while True:
        found = task(kind, seed)
        if found.verb == codes.FORWARD:
            return found
        seed += 1_000_000
