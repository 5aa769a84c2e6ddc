"""A byte-accurate RPLIDAR S2 without its cable: requests in, replies and scans out.

Slamtec's protocol, little-endian; time is injected. Raw angles are clockwise.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Distances in m along our angles (radians, counter-clockwise, 0 forward); inf for nothing.
Ranger = Callable[[Array], Array]

SERIAL = b"SIM-S2-000000001"  # "SIM" marks simulated data
_INFO = bytes((0x71, 2, 1, 18)) + SERIAL
_STANDARD_HZ = 16000
_DENSE_HZ = 32000
_TURN_S = 0.1  # 10 Hz mirror
_SPIN_UP_S = 0.5
_REBOOT_S = 0.5
_CHUNK_S = 0.005
_POINTS_PER_CAPSULE = 40
_RANGE_M = (0.05, 30.0)
_NOISE_M = 0.006
_MISSING = 0.003  # share of points that come back as nothing
_QUALITY = 47

# What the chair itself blocks: (from deg, to deg, distance m), our angles.
CHAIR_ARCS = ((124.0, 236.0, 0.22),)


def _descriptor(length: int, loop: bool, kind: int) -> bytes:
    return b"\xa5\x5a" + struct.pack("<IB", length | (0x40000000 if loop else 0), kind)


class S2:
    """The device. `receive` takes what the host sends, `step` returns what the device sends."""

    def __init__(self, ranger: Ranger, seed: int = 1) -> None:
        self._ranger = ranger
        self._random = np.random.default_rng(seed)
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
        self.corrupt = 0.0  # share of bytes
        self.drop = 0.0

    @property
    def scanning(self) -> bool:
        """Whether a scan was asked for."""
        return bool(self._scan)

    def power_on(self) -> None:
        """As after its supply came up: idle, the motor spinning up."""
        self._request.clear()
        self._out.clear()
        self._scan = ""
        self._motor = True
        self._spin_up_s = _SPIN_UP_S

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
            self._out += _descriptor(20, False, 0x04) + _INFO
        elif command == 0x52:
            status = (2, 0x0101) if self.protection_stop else (0, 0)
            self._out += _descriptor(3, False, 0x06) + struct.pack("<BH", *status)
        elif command == 0x59:
            self._out += _descriptor(4, False, 0x15) + struct.pack("<HH", 62, 31)
        elif command in (0x20, 0x21) and not self.protection_stop:
            self._out += _descriptor(5, True, 0x81)
            self._start("standard")
        elif command == 0x82 and len(payload) == 5 and not self.protection_stop:
            self._out += _descriptor(84, True, 0x85)
            self._start("dense")

    def _start(self, scan: str) -> None:
        self._scan = scan
        self._sample = 0
        self._due_s = 0.0

    def step(self, dt_s: float) -> bytes:
        """Advance by `dt_s`; returns the bytes the device sends, in chunks of about 5 ms."""
        self._reboot_s = max(0.0, self._reboot_s - dt_s)
        self._spin_up_s = max(0.0, self._spin_up_s - dt_s)
        if self.protection_stop:
            self._scan = ""
        if self._scan and self._motor and self._spin_up_s == 0.0 and not self.mirror_blocked:
            self._due_s += dt_s
            if self._due_s >= _CHUNK_S - 1e-9:
                self._emit()
        if not self._out or self.stalled:
            self._out.clear()
            return b""
        data = bytes(self._out)
        self._out.clear()
        return self._damage(data) if self.corrupt or self.drop else data

    def _emit(self) -> None:
        dense = self._scan == "dense"
        rate = _DENSE_HZ if dense else _STANDARD_HZ
        whole = _POINTS_PER_CAPSULE if dense else 1
        count = int(self._due_s * rate + 1e-6) // whole * whole
        if not count:
            return
        self._due_s -= count / rate
        per_turn = round(rate * _TURN_S)
        index = np.arange(self._sample, self._sample + count, dtype=np.int64)
        self._sample += count
        turns = (index % per_turn) / per_turn
        distances = self._measure(turns)
        if dense:
            self._capsules(turns, distances, first=bool(index[0] == 0))
        else:
            self._nodes(turns, distances)

    def _measure(self, turns: Array) -> Array:
        # Distances in mm at raw (clockwise) mirror positions; 0 is no measurement.
        ours = -2.0 * math.pi * turns
        metres = np.asarray(self._ranger(ours), dtype=np.float64)
        degrees = np.degrees(ours) % 360.0
        for start, stop, distance in CHAIR_ARCS:
            metres = np.where((degrees >= start) & (degrees <= stop), distance, metres)
        noise = self._random.standard_normal(len(turns)) * _NOISE_M
        seen = (metres >= _RANGE_M[0]) & (metres <= _RANGE_M[1])
        seen &= self._random.random(len(turns)) >= _MISSING
        return np.where(seen, (np.where(seen, metres, 0.0) + noise) * 1000.0, 0.0)

    def _nodes(self, turns: Array, distances: Array) -> None:
        nodes = np.empty((len(turns), 5), dtype=np.uint8)
        first = (turns == 0.0).astype(np.uint8)  # a new turn begins
        quality = np.where(distances > 0, _QUALITY, 0).astype(np.uint8)
        nodes[:, 0] = quality << 2 | (1 - first) << 1 | first
        angle = (turns * 360.0 * 64.0).astype(np.uint16) << 1 | 1
        nodes[:, 1:3] = angle.astype("<u2").view(np.uint8).reshape(-1, 2)
        fits = distances < 16384.0  # what 16 bits of quarter millimetres can say
        distance = np.where(fits, np.maximum(distances, 0.0) * 4.0, 0.0).astype("<u2")
        nodes[:, 3:5] = distance.view(np.uint8).reshape(-1, 2)
        self._out += nodes.tobytes()

    def _capsules(self, turns: Array, distances: Array, first: bool) -> None:
        count = len(turns) // _POINTS_PER_CAPSULE
        capsules = np.empty((count, 84), dtype=np.uint8)
        start = (turns[::_POINTS_PER_CAPSULE] * 360.0 * 64.0).astype("<u2")
        if first:
            start[0] |= 0x8000  # the encoder was reset; not set at each turn
        capsules[:, 2:4] = start.view(np.uint8).reshape(-1, 2)
        points = np.clip(distances, 0, 65535).astype("<u2").view(np.uint8)
        capsules[:, 4:] = points.reshape(count, 2 * _POINTS_PER_CAPSULE)
        checksum = np.bitwise_xor.reduce(capsules[:, 2:], axis=1)
        capsules[:, 0] = 0xA0 | (checksum & 0x0F)
        capsules[:, 1] = 0x50 | (checksum >> 4)
        self._out += capsules.tobytes()

    def _damage(self, data: bytes) -> bytes:
        octets = np.frombuffer(data, dtype=np.uint8).copy()
        hit = self._random.random(len(octets)) < self.corrupt
        octets[hit] ^= self._random.integers(1, 256, int(hit.sum())).astype(np.uint8)
        kept: NDArray[np.uint8] = octets[self._random.random(len(octets)) >= self.drop]
        return kept.tobytes()
