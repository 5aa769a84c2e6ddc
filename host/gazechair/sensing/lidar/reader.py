"""One lidar's thread: opens its device, keeps its newest scan, and reopens it when it fails."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from gazechair.base import health as states
from gazechair.base.throttled_log import ThrottledLog
from gazechair.config.settings import LidarConfig
from gazechair.sensing.lidar.device import S2, LidarError, find_port
from gazechair.sensing.lidar.nodes import Nodes
from gazechair.sensing.lidar.report import FROZEN, LOST, MIRROR, POWER, SILENT, STARTING
from gazechair.sensing.lidar.scan import Placing, Scan
from gazechair.sensing.lidar.scanfile import ScanFileError, ScanReader
from gazechair.sensing.lidar.stream import ByteStream, NodeStream, Tap
from gazelink import codes

throttled = ThrottledLog(logging.getLogger(__name__))

_READ_S = 0.05
# Longest wait for the end of a quarter turn (some 25 ms): one large piece is cheap to decode.
_GATHER_S = 0.030
_LOOK_S = 0.0005  # after its last byte is due: bytes arrive in chunks
# A terminal keeps 4095 unread bytes; near that, its driver may stop taking more from the device.
_KEPT_BYTES = 3900
_SETTLE_S = 0.01  # until bytes that waited in the device and its driver have come as well
_SILENT_S = 0.25  # without measurements: the scan no longer counts
_GIVE_UP_S = 0.5  # without measurements: the device is reopened
_FIRST_S = 5.0  # until the first measurements; the motor runs up meanwhile
_RETRY_S = (0.25, 2.0)


@dataclass(frozen=True)
class Condition:
    """A lidar's condition: health state, reason key, one plain line."""

    state: str
    reason: str
    detail: str


class Reader:
    """Runs one lidar, from `start` to `stop`. Any thread may read its attributes at any time.

    `scan` is None while the lidar delivers nothing usable. `alive_s`: CLOCK_MONOTONIC seconds of
    its thread's last sign of life; every wait in that thread ends within about 6 s.
    """

    def __init__(
        self,
        config: LidarConfig,
        renewed: Callable[[], None],
        tap: Tap | None = None,
        placing: Placing | None = None,
    ) -> None:
        """`renewed` is called on the reader's thread whenever `scan` or `condition` has changed,
        `tap` with all measurements but old ones that a frozen device repeats; `placing` places
        those of the scans."""
        self._tap = tap
        self._taps = (self._hand_on if tap is not None else None, placing)
        self.config = config
        self.scan: Scan | None = None
        self.stream: NodeStream | None = None
        self.source: int | None = None
        self.condition = Condition(states.STARTING, STARTING, "starting")
        self.alive_s = time.monotonic()
        self._delivered = False  # since the device was opened
        self._renewed = renewed
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=config.name, daemon=True)

    def start(self) -> None:
        """Start its thread."""
        self._thread.start()

    def stop(self, timeout_s: float = 5.0) -> None:
        """End the scan, stop the motor, end the thread. Returns at once when it never started."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(timeout_s)

    def _run(self) -> None:
        pause_s = _RETRY_S[0]
        while not self._stopping.is_set():
            self.alive_s = time.monotonic()
            self._delivered = False
            try:
                if self.config.kind == "replay":
                    self._replay()
                else:
                    self._serve()
            except LidarError as error:
                self._report(states.LOST, error.reason, str(error))
            except ScanFileError as error:
                self._report(states.LOST, LOST, str(error))
            except Exception as error:  # of a library: it must not end the thread for good
                throttled.warn("lidar %s: an error", self.config.name, exc_info=True)
                self._report(states.LOST, LOST, f"{type(error).__name__}: {error}")
            if self._delivered:
                pause_s = _RETRY_S[0]
            self._stopping.wait(pause_s)
            pause_s = min(pause_s * 2.0, _RETRY_S[1])

    def _report(self, state: str, reason: str = "ok", detail: str = "") -> None:
        """A lost lidar stays lost, with its explanation, until it delivers."""
        if state == states.STARTING and self.condition.state == states.LOST:
            return
        self.condition = Condition(state, reason, detail)
        if state != states.OK:
            self.scan = None
        self._renewed()

    def _serve(self) -> None:
        self._report(states.STARTING, STARTING, f"opening the lidar at {self.config.port}")
        port = find_port(self.config.port)
        device = S2(port)
        try:
            self.alive_s = time.monotonic()
            self._report(states.STARTING, STARTING, f"lidar {device.serial.hex()}: motor starts")
            device.start(self.config.mode)
            if self.condition.reason == SILENT:
                text = f"the lidar at {port} had stopped by itself; check its power supply"
                self._report(states.LOST, POWER, text)
            self._read(device, port)
        finally:
            self.stream = None
            device.close()

    def _read(self, device: S2, port: str) -> None:
        self.source = codes.SIMULATED if device.simulated else codes.REAL
        stream = ByteStream(self.config.mode, self.source, *self._taps)
        self.stream = stream
        intake = Intake(device)
        received_s, patience_s = None, time.monotonic() + _FIRST_S
        while not self._stopping.is_set():
            data, came_s = intake.gathered(stream)
            self.alive_s = now_s = time.monotonic()
            last_s = stream.last_s
            if stream.feed(data, came_s):
                self._take(stream.scan())
            if stream.last_s != last_s:
                received_s = now_s  # what came late is no silence
            self._judge(stream.frozen, port, now_s, received_s, patience_s)

    def _replay(self) -> None:
        """Play the file at its own speed, in a loop."""
        self._report(states.STARTING, STARTING, f"opening {self.config.file}")
        file = ScanReader(Path(self.config.file))
        try:
            self.source = codes.REPLAYED
            while not self._stopping.is_set():
                self.stream = NodeStream(codes.REPLAYED, file.period_s, *self._taps)
                start_s = time.monotonic()
                for time_s, nodes in file.records():
                    if self._stopping.wait(max(0.0, start_s + time_s - time.monotonic())):
                        return
                    self.alive_s = now_s = time.monotonic()
                    if self.stream.take(nodes, now_s):
                        self._take(self.stream.scan())
                if not self._delivered:
                    raise ScanFileError(f"scan file {self.config.file} holds no whole turn")
        finally:
            self.stream = None
            file.close()

    def _hand_on(self, nodes: Nodes, received_s: float, period_s: float) -> None:
        if self._tap is not None and self.stream is not None and self.stream.trusted:
            self._tap(nodes, received_s, period_s)

    def _take(self, scan: Scan | None) -> None:
        if scan is None:
            return
        self.scan = scan
        self._delivered = True
        if self.condition.state == states.OK:
            self._renewed()
        else:
            self._report(states.OK)

    def _judge(
        self, frozen: bool, port: str, now_s: float, received_s: float | None, patience_s: float
    ) -> None:
        if frozen:
            raise LidarError(f"the lidar at {port} repeats the same data; unplug it once", FROZEN)
        if received_s is None:
            if now_s > patience_s:
                raise LidarError(
                    f"the lidar at {port} sends no measurements; is its motor turning?", MIRROR
                )
        elif now_s - received_s > _SILENT_S:
            text = f"the lidar at {port} sends nothing; check its plug and power supply"
            if now_s - received_s > _GIVE_UP_S:
                raise LidarError(text, SILENT)
            if self.scan is not None:
                self._report(states.LOST, SILENT, text)


class Intake:
    """Reads a device's bytes, and dates them."""

    def __init__(self, device: S2) -> None:
        self._device = device
        self._emptied_s = time.monotonic()  # then nothing older was left unread

    def gathered(self, stream: ByteStream) -> tuple[bytes, float]:
        """The bytes until the quarter turn should be complete, and when the last ones arrived."""
        came_s = time.monotonic()
        end_s = came_s + _GATHER_S
        if stream.last_s is not None:
            came_s = stream.last_s
        data, missing = b"", stream.wants
        while missing > 0 or not data:
            # A read costs as much as many small computations: none before data is due.
            due_s = min(came_s + missing * stream.byte_s, end_s) + _LOOK_S
            time.sleep(max(0.0, due_s - time.monotonic()))
            read_s = time.monotonic()
            more = self._device.read(max(0.0, end_s - read_s) if data else _READ_S)
            now_s = time.monotonic()
            if more and now_s - self._emptied_s > _KEPT_BYTES * stream.byte_s:
                return self._late(data, more, now_s, stream.byte_s)
            self._emptied_s = read_s
            if not more:
                break
            data += more
            came_s = now_s
            missing = stream.wants - len(data) if came_s < end_s else 0
        return data, came_s

    def _late(self, data: bytes, more: bytes, now_s: float, byte_s: float) -> tuple[bytes, float]:
        """As gathered(), after a pause so long that bytes may have been lost: the kernel keeps the
        oldest ones. All count from the beginning of the pause: none seems younger than it is."""
        since_s, end_s = self._emptied_s, now_s + _SETTLE_S
        data, count = data + more, len(more)
        while self._emptied_s < end_s or len(more) >= _KEPT_BYTES:
            self._emptied_s = time.monotonic()
            more = self._device.read(_SETTLE_S / 4.0)
            data, count = data + more, count + len(more)
        return data, min(time.monotonic(), since_s + count * byte_s)
