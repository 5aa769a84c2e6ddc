"""The host in lockstep: control, arbiter, link protocol and lidar pipeline, without its threads."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any
from unittest import mock

from gazechair.base.health import OK, HealthRegistry
from gazechair.board.board_commands import Clearance
from gazechair.board.zone import BoardZone
from gazechair.config.settings import Config
from gazechair.driving.arbiter import LOOK_S
from gazechair.driving.control import Control
from gazechair.driving.driver_port import DriverPort
from gazechair.sensing.clearance.evaluate import Evaluator, footprint_of
from gazechair.sensing.lidar import zone_message
from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import Pose, Scan, to_chair
from gazechair.sensing.lidar.stream import ByteStream
from gazechair.web.page_client import decode
from gazelink import codes
from gazesim.lockstep_link import LockstepLink
from gazesim.usb_line import UsbLine
from gazesim.world import ONE, TWO, Mount

GATHER_MS = 20  # the lidar child's pace
UPDATE_MS = round(1000 * LOOK_S)
MASKS = {ONE: ((122.0, -122.0),), TWO: ((-180.0, -90.0),)}
"""Arcs of each lidar that the simulated chair hides."""
_SCAN_REQUEST = b"\xa5\x20"


class Host:
    """The daemon. `frozen`: stopped as by SIGSTOP; arriving data waits for it."""

    def __init__(
        self,
        line: UsbLine,
        ask_lidars: Sequence[Callable[[bytes], None]],
        clock: Callable[[], float],
        mounts: tuple[Mount, ...] = ONE,
    ) -> None:
        numbers = random.Random(int(clock() * 1000) + 1)
        with mock.patch("secrets.randbelow", numbers.randrange):
            self.link = LockstepLink(line, clock, partial(numbers.randrange, 1, 65536))
            self.parts = HealthRegistry(clock)
            for name in ("board", "lidar", "camera"):
                self.parts.part(name).set(OK)
            self.control = Control(Config(), self.link, self.parts, clock=clock)
        self.port: DriverPort = self.control
        self._clock = clock
        self.streams = [ByteStream("standard", codes.SIMULATED) for _ in mounts]
        self._poses = [Pose(*mount) for mount in mounts]
        self._mask = MASKS[mounts]
        self._blindness = [Blindness() for _ in mounts]
        self._scans: list[Scan | None] = [None for _ in mounts]
        origins = [(x_m, y_m) for x_m, y_m, _ in mounts]
        self.evaluate = Evaluator(footprint_of(Config().footprint), origins)
        self.link.on_zone = self._zone_received
        self._scan_bytes = [bytearray() for _ in mounts]
        self.inbox: deque[tuple[int, str]] = deque()  # from the pages' sockets
        self.frozen = False
        self.lidar_child = True  # False: its process has died, and is not started again
        self.refusals: list[str] = []
        for ask_lidar in ask_lidars:
            ask_lidar(_SCAN_REQUEST)

    def _zone_received(self, zone: BoardZone) -> None:
        self.evaluate.zone = zone_message.unpack(zone_message.pack(zone))

    def scan(self, sent: Sequence[bytes]) -> None:
        """Bytes from each lidar."""
        if self.lidar_child:
            for kept, data in zip(self._scan_bytes, sent, strict=True):
                if data:
                    kept += data

    def one_ms(self, now_ms: int) -> None:
        """One millisecond of the daemon's life."""
        if self.frozen:
            return
        while self.inbox:
            client, text = self.inbox.popleft()
            self._hear_page(client, text)
        self.link.one_ms()
        if now_ms % GATHER_MS == 0 and self.lidar_child:
            self._judge_scan()
        if now_ms % UPDATE_MS == 0:
            self.control.update()

    def _hear_page(self, client: int, text: str) -> None:
        message = decode(text)
        if isinstance(message, str):
            self.refusals.append("bad_message")
            return
        for refusal in self.port.receive(client, message):
            self.refusals.append(refusal["reason"])

    def _judge_scan(self) -> None:
        changed = False
        for at, (kept, stream) in enumerate(zip(self._scan_bytes, self.streams, strict=True)):
            data = bytes(kept)
            kept.clear()
            if data and stream.feed(data, self._clock()):
                self._scans[at] = stream.scan()
                changed = True
        scans = [scan for scan in self._scans if scan is not None]
        if not changed or len(scans) < len(self._scans):
            return
        views = tuple(
            to_chair(scan, pose, self._mask, blindness)
            for scan, pose, blindness in zip(scans, self._poses, self._blindness, strict=True)
        )
        oldest_s = min(scan.acquired_s for scan in scans)
        found = self.evaluate(views)
        self.control.clearance(Clearance(source=codes.SIMULATED, acquired_s=oldest_s, **found))

    def look(self, client: int) -> dict[str, Any]:
        """The state that a page would receive now."""
        return self.control.snapshot(client)
