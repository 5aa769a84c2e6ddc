"""An emulated S2 in its own process: `python -m gazemeasure.lidar.emulator PATH`.

Its port is a pty at PATH. Like a serial port's driver, it buffers half a second of data for a slow
reader. Close its standard input to end it; it then prints one line of JSON: when each
turn of the scan was complete on the port (CLOCK_MONOTONIC seconds), and the bytes that were lost.
"""

from __future__ import annotations

import json
import select
import subprocess
import sys
import time

import numpy as np

from gazechair.base.arrays import FloatArray
from gazesim.pty_port import PtyPort
from gazesim.s2 import S2

_STEP_S = 0.001
_STALL_S = 0.020  # a stalled machine pauses the lidar
_KEPT_BYTES = 33_600
_TURN_BYTES = 80 * 84
_DESCRIPTOR_BYTES = 7
MASK = ((123.0, -123.0),)
"""Arcs that its reader must mask: there the lidar sees the chair."""


def room(angles: FloatArray) -> FloatArray:
    """Distances in m in a room of 6 x 4 m with four legs in it."""
    with np.errstate(divide="ignore"):
        metres = np.minimum(np.abs(3.0 / np.cos(angles)), np.abs(2.0 / np.sin(angles)))
    degrees = np.degrees(angles) % 360.0
    for leg_deg in (15.0, 75.0, 290.0, 345.0):
        metres[np.abs(degrees - leg_deg) < 0.8] = 1.2
    return np.asarray(metres)


def started(path: str) -> subprocess.Popen[str]:
    """The emulator in its own process, once its port exists; communicate() ends it."""
    process = subprocess.Popen(
        [sys.executable, "-m", "gazemeasure.lidar.emulator", path],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    process.stdout.readline()
    return process


class Emulator:
    """The device, its port, and what it counts."""

    def __init__(self, path: str) -> None:
        self._device = S2(room, chunk_s=0.00125)
        self._port = PtyPort(path)
        self._port.plug()
        self._pending = b""
        self._sent = 0
        self.lost = 0
        self.turn_ends_s: list[float] = []

    def step(self, dt_s: float) -> None:
        """Run for `dt_s`."""
        if command := self._port.read():
            self._device.receive(command)
        data = self._device.step(dt_s)
        if not self._device.scanning:
            self._sent = 0
            self.turn_ends_s.clear()
        self._pending += data
        self.lost += max(0, len(self._pending) - _KEPT_BYTES)
        self._pending = self._pending[-_KEPT_BYTES:]
        taken = self._port.write(self._pending)
        self._pending = self._pending[taken:]
        if self._device.scanning:
            self._sent += taken
            turns = (self._sent - _DESCRIPTOR_BYTES) // _TURN_BYTES
            now_s = time.monotonic()
            self.turn_ends_s += [now_s] * (turns - len(self.turn_ends_s))

    def close(self) -> None:
        """Take the port away."""
        self._port.unplug()


def main() -> int:
    """Run until the standard input is closed."""
    emulator = Emulator(sys.argv[1])
    print("ready", flush=True)
    last_s = time.monotonic()
    result = {}
    while not select.select([sys.stdin], [], [], 0)[0]:
        time.sleep(_STEP_S)
        now_s = time.monotonic()
        emulator.step(min(now_s - last_s, _STALL_S))
        last_s = now_s
        if emulator.turn_ends_s:
            result = {"turn_ends_s": list(emulator.turn_ends_s), "lost": emulator.lost}
    emulator.close()
    print(json.dumps(result), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
