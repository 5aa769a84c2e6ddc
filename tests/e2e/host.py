"""The host in lockstep: control, arbiter, link protocol and lidar pipeline, without its threads."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Callable
from typing import Any
from unittest import mock

from e2e.cable import Cable
from gazechair.base.health import OK, HealthRegistry
from gazechair.board.board_commands import Bypass, Clearance, Command
from gazechair.board.protocol import FaultText, LinkProtocol, SessionBegun, SessionEnded
from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.board.zone import NOT_KNOWN, BoardZone
from gazechair.config.configuration import Config
from gazechair.driving.control import Control
from gazechair.sensing.clearance.evaluate import Evaluator, footprint_of
from gazechair.sensing.lidar.blind import Blindness
from gazechair.sensing.lidar.scan import Pose, to_chair
from gazechair.sensing.lidar.stream import ByteStream
from gazechair.sensing.lidar.told import said, understood
from gazechair.web.page_client import decode
from gazelink import codes
from gazesim.world import LIDAR_X_M

_SEARCH_MS = 100  # between two looks for the port
_READ_SIZE = 1024
_GATHER_MS = 20  # the lidar child's pace
_UPDATE_MS = 25
_POSE = Pose(LIDAR_X_M)
_MASK = ((122.0, -122.0),)  # what the simulated chair hides
_SCAN_REQUEST = b"\xa5\x20"


class Link:
    """The host's BoardLink in virtual time: one port, nothing queued but an unsent frame."""

    def __init__(self, cable: Cable, clock: Callable[[], float], draw: Callable[[], int]) -> None:
        self._cable = cable
        self._clock = clock
        self.protocol = LinkProtocol(draw)
        self._unsent = b""
        self._open = False
        self._search_in_ms = 1
        self._state: BoardState | None = None
        self._stats: BoardStats | None = None
        self.on_zone: Callable[[BoardZone], None] = lambda _zone: None
        self.sessions = 0
        self.last_words: list[str] = []

    # What Control asks of a link

    def command(self, command: Command) -> None:
        self.protocol.command(command, self._clock())
        self._flush()

    def order(self, action: int, owner: int) -> None:
        self.protocol.order(action, owner, self._clock())
        self._flush()

    def clearance(self, clearance: Clearance) -> None:
        self.protocol.clearance(clearance, self._clock())
        self._flush()

    def bypass(self, bypass: Bypass | None) -> None:
        self.protocol.bypass(bypass, self._clock())
        self._flush()

    def state(self) -> BoardState | None:
        return self._state

    def stats(self) -> BoardStats | None:
        return self._stats

    def board(self) -> BoardId | None:
        return self.protocol.board

    # Its thread

    def one_ms(self) -> None:
        """What BoardLink's thread does when it wakes."""
        if not self._open:
            self._search_in_ms -= 1
            if self._search_in_ms <= 0 and self._cable.plugged:
                self._open = self._cable.host_reads = True
                self._unsent = b""
                self.protocol.opened(self._clock())
        if self._open and not self._cable.plugged:
            self.close()
            self.protocol.opened(self._clock())
            self._state = None
            self.on_zone(NOT_KNOWN)
        if not self._open:
            return
        now_s = self._clock()
        data = self._cable.to_host.take(_READ_SIZE)
        for event in [*self.protocol.feed(data, now_s), *self.protocol.check(now_s)]:
            if isinstance(event, BoardState):
                self._state = event
            elif isinstance(event, SessionBegun):
                self.sessions += 1
            elif isinstance(event, BoardStats):
                self._stats = event
            elif isinstance(event, SessionEnded):
                self._state = None
                self.on_zone(NOT_KNOWN)
            elif isinstance(event, BoardZone):
                self.on_zone(event)
            elif isinstance(event, FaultText):
                self.last_words.append(event.reason)
        self._flush()

    def close(self) -> None:
        """The port is closed, by us or because it vanished."""
        self._open = self._cable.host_reads = False
        self._search_in_ms = _SEARCH_MS

    def _flush(self) -> None:
        if not self._open or not self._cable.plugged:
            return
        if not self._unsent:
            self._unsent = self.protocol.poll(self._clock())
        taken = self._unsent[: self._cable.to_board.room()]
        if taken:
            self._cable.to_board.put(taken, self._cable.now_ms)
            self._unsent = self._unsent[len(taken) :]


class Host:
    """The daemon. `frozen`: stopped by SIGSTOP; what comes in meanwhile waits for it."""

    def __init__(
        self, cable: Cable, ask_lidar: Callable[[bytes], None], clock: Callable[[], float]
    ) -> None:
        numbers = random.Random(int(clock() * 1000) + 1)
        with mock.patch("secrets.randbelow", numbers.randrange):
            self.link = Link(cable, clock, lambda: numbers.randrange(1, 65536))
            parts = HealthRegistry(clock)
            for name in ("board", "lidar", "camera"):
                parts.part(name).set(OK)
            self.control = Control(Config(), self.link, parts, clock=clock)
        self._clock = clock
        self._stream = ByteStream("standard", codes.SIMULATED)
        self._blindness = Blindness()
        self.evaluate = Evaluator(footprint_of(Config().footprint), [(_POSE.x_m, _POSE.y_m)])
        self.link.on_zone = self._zone_told
        self._scan_bytes = bytearray()
        self.inbox: deque[tuple[int, str]] = deque()  # from the pages' sockets
        self.frozen = False
        self.lidar_child = True  # False: its process has died, and is not started again
        self.refusals: list[str] = []
        ask_lidar(_SCAN_REQUEST)

    def _zone_told(self, zone: BoardZone) -> None:
        self.evaluate.zone = understood(said(zone))

    def scan(self, data: bytes) -> None:
        """Bytes from the lidar."""
        if self.lidar_child:
            self._scan_bytes += data

    def one_ms(self, now_ms: int) -> None:
        """One millisecond of the daemon's life."""
        if self.frozen:
            return
        while self.inbox:
            client, text = self.inbox.popleft()
            self._hear_page(client, text)
        self.link.one_ms()
        if now_ms % _GATHER_MS == 0 and self.lidar_child:
            self._judge_scan()
        if now_ms % _UPDATE_MS == 0:
            self.control.update()

    def _hear_page(self, client: int, text: str) -> None:
        message = decode(text)
        if isinstance(message, str):
            self.refusals.append("bad_message")
            return
        for refusal in self.control.receive(client, message):
            self.refusals.append(refusal["reason"])

    def _judge_scan(self) -> None:
        data = bytes(self._scan_bytes)
        self._scan_bytes.clear()
        if not data or not self._stream.feed(data, self._clock()):
            return
        scan = self._stream.scan()
        if scan is None:
            return
        found = self.evaluate((to_chair(scan, _POSE, _MASK, self._blindness),))
        self.control.clearance(
            Clearance(source=codes.SIMULATED, acquired_s=scan.acquired_s, **found)
        )

    def look(self, client: int) -> dict[str, Any]:
        """What a page would be told now."""
        return self.control.snapshot(client)
