"""A small host for tests on a live board: says exactly what a test wants said, hears everything."""

import os
import select
import time
from collections import deque
from pathlib import Path
from typing import Any

from gazechair.board.serial_port import PortError, SerialPort
from gazelink import codes, frame, messages
from gazesim.small_host import STOP, SmallHost, clearance

OVERTAKEN_MS = 100
SPEAK_MS = 20
SPEAK_S = 0.2  # wall time, for a board that tells no time
HELLO_S = 0.2
ORDER_REPEATS = 10
NEUTRAL_OUTPUT = (0, 0)  # as STATE tells it, permille


class LiveHost(SmallHost):
    """Handshakes anew whenever it has to; `poll` does all the work and never blocks.

    Times are `ticks`: the board's own clock, its stamps made continuous. While `talking`, it
    repeats `command` and obstacle data every 20 ms of the board's time, as the real host does.
    """

    def __init__(self, path: Path, source: int) -> None:
        self.path = path
        self.source = source
        self.talking = True
        self.connected = True  # False: keeps the port closed
        self.wrong_schema = False
        self.command = STOP
        self.blocked = 0
        self.hellos: list[dict[str, Any]] = []
        self.states: deque[tuple[int, dict[str, Any]]] = deque(maxlen=3000)
        self.stats: dict[str, Any] = {}
        self.pongs: dict[int, int] = {}  # token -> ticks of the answer
        self.faults: list[dict[str, Any]] = []
        self.maintenance: dict[str, Any] | None = None
        self.recent_bytes = bytearray()  # every byte, the last few thousand
        self.sent = b""  # the last frame with a motion in it
        self.ticks = 0
        self._sessions = int.from_bytes(os.urandom(1), "little")
        self._port: SerialPort | None = None
        self._orders: list[tuple[tuple[int, int, int], int]] = []
        self._speak_at_s = 0.0
        self._speak_at = 0
        self._hello_at_s = 0.0
        super().__init__(self._next_session())

    def _next_session(self) -> int:
        self._sessions = (self._sessions + 1) & 0xFF
        return 0x4700 | self._sessions

    def lost(self) -> None:
        """The session is over: another one, please."""
        self.renew(self._next_session())

    @property
    def in_session(self) -> bool:
        """The board and this host agree on a session."""
        return bool(self.keys.live)

    @property
    def state(self) -> dict[str, Any]:
        """The newest state frame; empty before the first."""
        return self.states[-1][1] if self.states else {}

    @property
    def safety(self) -> int:
        """The board's state; -1 while it has said nothing."""
        return int(self.state["status"]) & 0x0F if self.state else -1

    @property
    def output(self) -> tuple[int, int]:
        """Linear and turn output as the board tells them, permille; neutral until it has."""
        if not self.state:
            return NEUTRAL_OUTPUT
        return self.state["linear_permille"], self.state["turn_permille"]

    def has_fault(self, bit: int) -> bool:
        """Whether the newest state has that fault."""
        return bool(self.state) and bool(self.state["faults"] >> bit & 1)

    def hold(self, verb: int, edge: int, mode: int = codes.CONTINUOUS) -> None:
        """Command it from now on, held by a driver who keeps proving it."""
        self.command = (verb, mode, edge, codes.DRIVER, 300, 0, 0, 1000, 0)

    def order(self, action: int, owner: int = codes.DRIVER) -> None:
        """Give an order, repeated as against loss."""
        self._orders.append((self.next_order(action, owner), ORDER_REPEATS))

    def put(self, buf: bytearray, n: int) -> None:
        """Send a frame now."""
        self._last = bytes(buf[:n])
        self.raw(self._last)

    def raw(self, data: bytes) -> None:
        """Send bytes as they are; lost when the port is closed or the board does not take them."""
        try:
            while self._port is not None and data:
                taken = self._port.write(data)
                data = data[taken:]
                if not taken:
                    select.select([], [self._port.fileno()], [], 0.05)
        except PortError:
            self.close()

    def close(self) -> None:
        """Close the port; what was known of the session is forgotten."""
        if self._port is not None:
            self._port.close()
            self._port = None
        self.lost()

    def poll(self) -> None:
        """Open the port if need be, hear what came, say what is due."""
        if not self.connected:
            if self._port is not None:
                self.close()
            return
        if self._port is None:
            try:
                self._port = SerialPort(str(self.path))
            except PortError:
                return
        self._listen(self._port)
        if self._port is not None:
            self._speak(time.monotonic())

    def _listen(self, port: SerialPort) -> None:
        ready = select.poll()
        ready.register(port.fileno(), select.POLLIN)
        events = ready.poll(0)
        if not events:
            return
        if events[0][1] & (select.POLLHUP | select.POLLERR):
            self.close()
            return
        try:
            data = port.read()
        except PortError:
            self.close()
            return
        self.recent_bytes += data
        del self.recent_bytes[:-8192]
        self.hear(data, len(data))

    def received(self, kind: int, buf: bytearray) -> None:
        """A frame of the board's."""
        # A state is stamped when it is captured: an answer sent meanwhile may overtake it.
        back = -self.passed_ms & 0xFFFF
        self.ticks += -back if back < OVERTAKEN_MS else self.passed_ms
        if kind == messages.STATE.type_id:
            self.states.append((self.ticks, messages.STATE.unpack(buf)))
        elif kind == messages.STATS.type_id:
            self.stats = messages.STATS.unpack(buf)
        elif kind == messages.PONG.type_id:
            self.pongs[messages.PONG.unpack(buf)["token_low"]] = self.ticks
        elif kind == messages.FAULT.type_id:
            self.faults.append(messages.FAULT.unpack(buf))
        elif kind == messages.MAINTENANCE.type_id:
            self.maintenance = messages.MAINTENANCE.unpack(buf)

    def greeted(self, hello: dict[str, Any]) -> None:
        """The board's HELLO, or an echo of ours by something that is no board."""
        if hello["role"] == 1:
            self.hellos.append(hello)
            super().greeted(hello)

    def _speak(self, now_s: float) -> None:
        if not self.talking:
            return
        if not self.in_session:
            if now_s - self._hello_at_s >= HELLO_S:
                self._hello_at_s = now_s
                self.say_hello(schema=frame.schema_hash() ^ self.wrong_schema)
            return
        if self.ticks - self._speak_at < SPEAK_MS and now_s - self._speak_at_s < SPEAK_S:
            return
        self._speak_at = self.ticks
        self._speak_at_s = now_s
        self.send(messages.COMMAND, self.command)
        if self.command[0] != codes.STOP:
            self.sent = self._last
        self.send(messages.CLEARANCE, clearance(self.blocked, self.source, 5))
        if self._orders:
            values, left = self._orders.pop(0)
            self.send(messages.ORDER, values)
            if left > 1:
                self._orders.insert(0, (values, left - 1))
