"""A byte-accurate RPLIDAR S2 without its cable: requests in, replies and scans out.

Slamtec's protocol, little-endian; time is injected. Raw angles are clockwise.
"""

from __future__ import annotations

import struct

import numpy as np

from gazesim import s2_frames
from gazesim.s2_beams import CHAIR_ARCS, Beams, Ranger
from gazesim.s2_frames import POINTS_PER_CAPSULE, descriptor

__all__ = ["CHAIR_ARCS", "S2", "SERIAL", "Ranger"]

SERIAL = b"SIM-S2-000000001"  # "SIM" marks simulated data
_INFO = bytes((0x71, 2, 1, 18)) + SERIAL
_STANDARD_HZ = 16000
_DENSE_HZ = 32000
_TURN_S = 0.1  # 10 Hz mirror
_SPIN_UP_S = 0.5
_REBOOT_S = 0.5


class S2:
    """The device. `receive` takes what the host sends, `step` returns what the device sends.

    Its faults are plain attributes, here and in `beams`; `corrupt` and `drop` are shares of the
    bytes it sends.
    """

    def __init__(self, ranger: Ranger, seed: int = 1, chunk_s: float = 0.005) -> None:
        """`chunk_s`: in pieces of how long it sends its scan."""
        self._random = np.random.default_rng(seed)
        self.beams = Beams(ranger, self._random)
        self._chunk_s = chunk_s
        self._request = bytearray()
        self._out = bytearray()
        self._scan = ""  # "", "standard" or "dense"
        self._motor = True  # spins from power-on
        self._spin_up_s = 0.0
        self._reboot_s = 0.0
        self._due_s = 0.0
        self._sample = 0  # of the running scan
        self.stalled = False
        self.protection_stop = False
        self.mirror_blocked = False
        self.corrupt = 0.0
        self.drop = 0.0

    @property
    def scanning(self) -> bool:
        """Whether a scan was requested."""
        return bool(self._scan)

    def power_on(self) -> None:
        """As after its supply came up: idle, the motor spinning up."""
        self._request.clear()
        self._out.clear()
        self._scan = ""
        self._motor = True
        self._spin_up_s = _SPIN_UP_S

    def power_dip(self) -> None:
        """As after a supply dip: idle, motor off, earlier requests forgotten."""
        self.power_on()
        self._motor = False

    def receive(self, data: bytes) -> None:
        """Take bytes from the host; what is no request is skipped."""
        self._request += data
        request = self._request
        while True:
            start = request.find(0xA5)
            if start < 0:
                request.clear()
                return
            del request[:start]
            if len(request) < 2:
                return
            command = request[1]
            if not command & 0x80:
                del request[:2]
                self._obey(command, b"")
                continue
            if len(request) < 3 or len(request) < 4 + request[2]:
                return
            end = 3 + request[2]
            checksum = 0
            for byte in request[:end]:
                checksum ^= byte
            payload, good = bytes(request[3:end]), checksum == request[end]
            del request[: end + 1]
            if good:
                self._obey(command, payload)

    def _obey(self, command: int, payload: bytes) -> None:
        if self._reboot_s > 0.0:
            return
        if command == 0x25:  # STOP
            self._scan = ""
        elif command == 0x40:  # RESET
            self.power_on()
            self._reboot_s = _REBOOT_S
        elif command == 0xA8 and len(payload) == 2:  # motor speed
            running = struct.unpack("<H", payload)[0] > 0
            if running and not self._motor:
                self._spin_up_s = _SPIN_UP_S
            self._motor = running
        elif self._scan:
            return  # a scanning device listens to STOP, RESET and its motor only
        elif command == 0x50:
            self._out += descriptor(20, False, 0x04) + _INFO
        elif command == 0x52:
            status = (2, 0x0101) if self.protection_stop else (0, 0)
            self._out += descriptor(3, False, 0x06) + struct.pack("<BH", *status)
        elif command == 0x59:
            self._out += descriptor(4, False, 0x15) + struct.pack("<HH", 62, 31)
        elif command in (0x20, 0x21) and not self.protection_stop:
            self._out += descriptor(5, True, 0x81)
            self._start("standard")
        elif command == 0x82 and len(payload) == 5 and not self.protection_stop:
            self._out += descriptor(84, True, 0x85)
            self._start("dense")

    def _start(self, scan: str) -> None:
        self._scan = scan
        self._sample = 0
        self._due_s = 0.0

    def step(self, dt_s: float) -> bytes:
        """Advance by `dt_s`; returns the bytes the device sends, in chunks."""
        if self._reboot_s or self._spin_up_s:
            self._reboot_s = max(0.0, self._reboot_s - dt_s)
            self._spin_up_s = max(0.0, self._spin_up_s - dt_s)
        if self.protection_stop:
            self._scan = ""
        if self._scan and self._motor and self._spin_up_s == 0.0 and not self.mirror_blocked:
            self._due_s += dt_s
            if self._due_s >= self._chunk_s - 1e-9:
                self._emit()
        if not self._out:
            return b""
        if self.stalled:
            self._out.clear()
            return b""
        data = bytes(self._out)
        self._out.clear()
        return self._damage(data) if self.corrupt or self.drop else data

    def _emit(self) -> None:
        dense = self._scan == "dense"
        rate = _DENSE_HZ if dense else _STANDARD_HZ
        whole = POINTS_PER_CAPSULE if dense else 1
        count = int(self._due_s * rate + 1e-6) // whole * whole
        if not count:
            return
        self._due_s -= count / rate
        first = self._sample
        self._sample += count
        turns, distances = self.beams.measure(first, count, round(rate * _TURN_S))
        if dense:
            rows = s2_frames.capsules(turns, distances, after_reset=first == 0)
        else:
            rows = s2_frames.nodes(turns, distances)
        self._out += rows.tobytes()

    def _damage(self, data: bytes) -> bytes:
        octets = np.frombuffer(data, dtype=np.uint8)
        return s2_frames.damaged(octets, self._random, self.corrupt, self.drop).tobytes()
