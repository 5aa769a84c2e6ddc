"""Watches the computer itself: whether it is too slow or too hot to drive well."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from pathlib import Path

from gazechair.base import health as states
from gazechair.base.health import Health

LOOK_S = 1.0
LATE_S = 0.15  # the board stops the chair after 0.1 s without a frame; see HOST_SILENT_MS
WINDOW = 10  # looks
MANY = 5  # of them late: the computer is slow; none late: it no longer is
HOT_C = 90.0  # processors slow down near 100
COOL_C = 85.0
_NONSENSE_C = 150.0


class Machine:
    """The part "host": degraded while the computer is too slow or too hot."""

    def __init__(
        self,
        health: Health,
        late_s: Callable[[], float],
        thermal: Path = Path("/sys/class/thermal"),
    ) -> None:
        """`late_s`: the longest delay of the driving thread since the last call, s."""
        self._health = health
        self._health.set(states.OK)
        self._late_s = late_s
        self._thermal = thermal
        self._late: deque[bool] = deque(maxlen=WINDOW)
        self._slow = False
        self._hot = False
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="machine", daemon=True)

    def start(self) -> None:
        """Start measuring, once a second."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(5.0)

    def look(self) -> None:
        """Measure once."""
        self._late.append(self._late_s() > LATE_S)
        self._slow = sum(self._late) >= (1 if self._slow else MANY)
        hottest_c = self._hottest_c()
        self._hot = hottest_c >= (COOL_C if self._hot else HOT_C)
        if self._hot:
            detail = f"a sensor of the computer measures {hottest_c:.0f} degrees Celsius"
            self._health.set(states.DEGRADED, "host_hot", detail)
        elif self._slow:
            detail = f"driving was late in {sum(self._late)} of the last {WINDOW} seconds"
            self._health.set(states.DEGRADED, "host_slow", detail)
        else:
            self._health.set(states.OK)

    def _run(self) -> None:
        while not self._stopping.wait(LOOK_S):
            self.look()

    def _hottest_c(self) -> float:
        found = [0.0]
        for file in self._thermal.glob("thermal_zone*/temp"):
            try:
                found.append(int(file.read_text()) / 1000)
            except (OSError, ValueError):  # that sensor is off
                continue
        return max(value for value in found if value < _NONSENSE_C)
