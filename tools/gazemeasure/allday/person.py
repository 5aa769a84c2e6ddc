"""A driver who drives all day: arms and presses by themselves, and connects again when cut off."""

from __future__ import annotations

import contextlib
import itertools
import math
import threading
import time
from pathlib import Path
from typing import Any

from gazedemo.check import NEUTRAL
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.page.raw_page import RawDriver
from gazemeasure.stalls import StallProbe

_HOLD_S = 0.25
_REST_S = 0.35
_ARM_S = 2.0
_RETRY_S = 0.2
_LOOK_S = 0.05
_VERBS = ("forward", "forward", "left", "forward", "forward", "right")
_FAR_M = 3.0  # from the start: then it turns round, and drives back
_AIMED_DEG, _TURN_S = 20.0, 4.0


class Person:
    """The driver; use as a context. Only arms and presses."""

    def __init__(self, stack: Stack, probe: StallProbe) -> None:
        self._stack = stack
        self._probe = probe
        self._cookie = stack.cookie("driver", "person")
        self._sim = SimControl(Path(stack.paths["control"]))
        self.presses = 0
        self.moved_s: list[float] = []
        """Monotonic times at which the wipers followed a press."""
        self.to_wipers: list[tuple[float, float]] = []
        """(monotonic s, ms) of the presses that met no stall of the machine."""
        self.state: dict[str, Any] = {}
        """The host's last state for the page that drives, or drove."""
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="person", daemon=True)

    def __enter__(self) -> Person:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._stopping.set()
        self._thread.join(30.0)
        self._sim.close()

    def drove_after(self, since_s: float, limit_s: float) -> float:
        """Seconds from then until the wipers followed a press; inf: not within `limit_s`."""
        while time.monotonic() - since_s < limit_s:
            found = [at_s for at_s in self.moved_s[-5:] if at_s > since_s]
            if found:
                return found[0] - since_s
            time.sleep(0.02)
        return float("inf")

    def _run(self) -> None:
        while not self._stopping.wait(_RETRY_S):
            # The page is cut off, or the chair does not arm in time: try again.
            with (
                contextlib.suppress(OSError, TimeoutError),
                RawDriver(self._stack.port, self._cookie) as driver,
            ):
                try:
                    self._drive(driver)
                finally:
                    self.state = driver.state

    def _drive(self, driver: RawDriver) -> None:
        for verb in itertools.cycle(_VERBS):
            if not driver.connected or self._stopping.is_set():
                return
            driver.arm(_ARM_S)
            off_deg = self._off_deg()
            driver.button["verb"] = verb if not off_deg else "left" if off_deg > 0.0 else "right"
            mark = self._sim.do("wiper_log", since=0)["last"]
            down_s = driver.press()
            self._stopping.wait(_HOLD_S)
            while off_deg and self._off_deg() and time.monotonic() < down_s + _TURN_S:
                self._stopping.wait(_LOOK_S)
            driver.release()
            self._stopping.wait(_REST_S)
            self._note(down_s, self._sim.do("wiper_log", since=mark)["entries"])

    def _off_deg(self) -> float:
        """How far it must turn to drive back, degrees, left positive; 0: it may drive on."""
        truth = self._sim.truth()
        x_m, y_m = truth["x_m"], truth["y_m"]
        back_deg = math.degrees(math.atan2(-y_m, -x_m))
        off_deg = math.remainder(back_deg - truth["heading_deg"], 360.0)
        drives_on = math.hypot(x_m, y_m) < _FAR_M or abs(off_deg) < _AIMED_DEG
        return 0.0 if drives_on else off_deg

    def _note(self, down_s: float, entries: list[list[Any]]) -> None:
        self.presses += 1
        moved = (one[1] for one in entries if one[1] >= down_s and (one[2], one[3]) != NEUTRAL)
        first_s = next(moved, None)
        if first_s is None:
            return
        self.moved_s.append(first_s)
        if not self._probe.stalled(down_s, first_s):
            self.to_wipers.append((first_s, 1000 * (first_s - down_s)))
