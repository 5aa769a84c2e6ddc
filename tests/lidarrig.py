"""An emulated S2 in a round room on a pty, run in real time, for tests of its readers."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from gazesim.pty_port import PtyPort
from gazesim.s2 import S2

LONG_S = 60.0


class LidarRig:
    """`front_m`: distance ahead; `babble`: bytes sent instead of its data."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.front_m = 3.0
        self.device = S2(self._range)
        self._port = PtyPort(path)
        self._port.plug()
        self._lock = threading.Lock()  # no read from an unplugged port
        self.babble = b""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._pump, name="lidar-rig", daemon=True)
        self._thread.start()

    def _range(self, angles: np.ndarray) -> np.ndarray:
        degrees = np.degrees(angles) % 360.0
        ahead = (degrees < 10.0) | (degrees > 350.0)
        return np.where(ahead, self.front_m, 3.0)

    def _pump(self) -> None:
        last_s = time.monotonic()
        while not self._stop.wait(0.004):
            with self._lock:
                self.device.receive(self._port.read())
                now_s = time.monotonic()
                # As the cable: a stalled test machine pauses the lidar, it does not flood the host.
                data = self.device.step(min(now_s - last_s, 0.02))
                last_s = now_s
                if self._port.plugged:
                    self._port.write(self.babble or data)

    def plug(self) -> None:
        """Plug in the cable, with power."""
        with self._lock:
            self.device.power_on()
            self._port.plug()

    def unplug(self) -> None:
        """Pull the cable."""
        with self._lock:
            self._port.unplug()

    def close(self) -> None:
        """End the thread and remove the port."""
        self._stop.set()
        self._thread.join(5.0)
        self._port.unplug()


def wait_for(condition: Callable[[], bool], what: Callable[[], object]) -> None:
    """Wait until `condition` is true; a failure names `what`."""
    deadline_s = time.monotonic() + LONG_S
    while not condition():
        assert time.monotonic() < deadline_s, what()
        time.sleep(0.01)
