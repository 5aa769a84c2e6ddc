"""A ride to the kitchen in real processes: how much of a core the host and all its parts take."""

from __future__ import annotations

import contextlib
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import gazesetup
from gazedemo import home, home_check
from gazedemo.check import CheckFailed
from gazedemo.stack import Stack
from gazemeasure.growth import cpu_s, family
from gazemeasure.report import Report

_SHARE = 60.0


def measure(report: Report) -> None:
    """Add the rows; where there is no Chromium, or the ride fails, a note with the reason."""
    try:
        chromium = gazesetup.ensure_chromium()
        micropython = str(gazesetup.ensure_micropython().path)
    except gazesetup.NotAvailable as error:
        report.note(f"a ride in real processes not measured: {error}")
        return
    with (
        tempfile.TemporaryDirectory(prefix="gazechair-") as name,
        Stack(micropython, home.ROOM, lidars=home.LIDARS, prepare=home.prepare) as stack,
    ):
        ride = Ride(lambda: family(stack.pid("host")))
        try:
            figures = home_check.check(stack, chromium, Path(name), ride)
        except CheckFailed as error:
            report.add("a ride in real processes: arrived", 0, "", 1, at_least=True)
            report.note(f"the ride in real processes: {error}")
            return
    report.add("a ride in real processes: arrived", 1, "", 1, at_least=True)
    report.add("  the host and all its parts: share of a core", 100.0 * ride.share, "%", _SHARE)
    report.add("  pressed again", figures["pressed_again"], "times")


class Ride:
    """The time of a ride, and what these processes take of a core meanwhile."""

    def __init__(self, pids: Callable[[], list[int]], clock: Callable[[], float] = time.monotonic):
        self._pids, self._clock = pids, clock
        self.share = math.nan

    def __enter__(self) -> Ride:
        self._begun_s, self._before_s = self._clock(), self._taken_s()
        return self

    def __exit__(self, *of_error: object) -> None:
        """Of a process that has begun meanwhile, all counts; of one that has ended, nothing."""
        taken_s = sum(s - self._before_s.get(pid, 0.0) for pid, s in self._taken_s().items())
        self.share = taken_s / (self._clock() - self._begun_s)

    def _taken_s(self) -> dict[int, float]:
        found = {}
        for pid in self._pids():
            with contextlib.suppress(OSError):
                found[pid] = cpu_s(pid)
        return found
