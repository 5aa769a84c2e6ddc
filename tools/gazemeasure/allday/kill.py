"""`kill -9` of the daemon while driving, seen from a real page: neutral, message, driving again."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import tempfile
import time
from pathlib import Path
from typing import Any

import gazesetup
from gazedemo.browser import Driver, open_page
from gazedemo.check import NEUTRAL
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.allday.faults import BACK_S, Well, daemon_waited_s
from gazemeasure.allday.service import Service, setting_s
from gazemeasure.report import Report
from gazemeasure.stalls import StallProbe

_NEUTRAL_MS = 105.0  # P2's 100, plus the simulator's sampling and the line's last bytes
_REPORTED_S = 1.0
_LIMIT_S = 60.0
_AGAIN_S = 0.5


class _Tries:
    """Kills on one running chair; the worst of each figure."""

    def __init__(self, stack: Stack, driver: Driver, probe: StallProbe) -> None:
        self._stack = stack
        self._sim: SimControl = stack.control()
        self._driver = driver
        self._probe = probe
        self.neutral_ms: list[float] = []
        self.reported_s: list[float] = []
        self.back_s: list[Well] = []

    def kill(self) -> None:
        """Drive, kill, and drive again."""
        self._drive(_LIMIT_S)
        time.sleep(0.3)
        mark = self._sim.do("wiper_log", since=0)["last"]
        killed_s = time.monotonic()
        os.kill(self._stack.pid("host"), signal.SIGKILL)
        link = self._driver
        link.wait(lambda: link.data("link") != "ok", _LIMIT_S, "the page says so")
        self.reported_s.append(time.monotonic() - killed_s)
        link.release()
        self._neutral(mark, killed_s)
        self._drive(_LIMIT_S)
        took_s = time.monotonic() - killed_s
        self.back_s.append(Well(took_s, daemon_waited_s(self._stack.pid("host"))))
        link.release()
        link.rest()

    def _drive(self, limit_s: float) -> None:
        """Arm and press as a driver does, until the wipers move."""
        end_s = time.monotonic() + limit_s
        with contextlib.suppress(RuntimeError):
            self._sim.do("teleport", x_m=0, y_m=0, heading_deg=0)
        while time.monotonic() < end_s:
            if self._driver.data("state") != "armed":
                self._driver.click("arm")
                self._until(lambda: self._driver.data("state") == "armed")
            else:
                self._driver.press("forward")
                if self._until(lambda: self._sim.wipers() != NEUTRAL):
                    return
                self._driver.release()
        raise TimeoutError(f"does not drive; the page: {self._driver.text('#status')}")

    def _until(self, true: Any) -> bool:
        with contextlib.suppress(TimeoutError):
            self._driver.wait(true, _AGAIN_S, "")
            return True
        return False

    def _neutral(self, mark: int, killed_s: float) -> None:
        self._sim.wait(lambda truth: tuple(truth["wipers"]) == NEUTRAL, _LIMIT_S, "neutral")
        entries = self._sim.do("wiper_log", since=mark)["entries"]
        after = [one[1] for one in entries if one[1] >= killed_s and (one[2], one[3]) == NEUTRAL]
        if not after:
            return  # a stall had stopped the chair just before
        at_s = after[0]
        took_ms = 1000 * (at_s - killed_s)
        # A stall only adds delay: a sample that is in time anyway counts.
        if took_ms <= _NEUTRAL_MS or not self._probe.stalled(killed_s, at_s):
            self.neutral_ms.append(took_ms)


def add(report: Report, micropython: str, tries: int) -> None:
    """Measure `tries` kills with an immediate restart, and as many with systemd's pause."""
    chromium = gazesetup.ensure_chromium()
    unit_s = setting_s("RestartSec")
    for restart_s in (0.0, 1.0):
        with tempfile.TemporaryDirectory(prefix="gazechair-") as name, StallProbe() as probe:
            service = Service(Path(name), restart_s)
            with (
                Stack(micropython, "open", environment=service.environment) as stack,
                service.of(stack),
                open_page(chromium, stack.invitation()) as driver,
            ):
                run = _Tries(stack, driver, probe)
                for _ in range(tries):
                    run.kill()
        report.add(f"kill -9, started after {restart_s:g} s: kills", tries, "")
        add_rows(report, run.neutral_ms, run.reported_s, run.back_s)
    report.note(f"kill -9: the unit file's RestartSec is {unit_s:g} s.")


def add_rows(
    report: Report, neutral_ms: list[float], reported_s: list[float], back_s: list[Well]
) -> None:
    """The kills of one chair. `neutral_ms` lacks those that a stall of the machine delayed."""
    worst_ms = max(neutral_ms, default=math.nan)
    report.add("  neutral, worst", worst_ms, "ms", _NEUTRAL_MS)
    report.add("    measured without a stall", 100.0 * len(neutral_ms) / len(reported_s), "%")
    report.add("  the page says so, worst", max(reported_s), "s", _REPORTED_S)
    own_s, took_s = (max(getattr(one, of) for one in back_s) for of in ("own_s", "took_s"))
    report.add("  driving again by arm and press, worst", own_s, "s", BACK_S)
    report.add("    and with waiting for a processor", took_s, "s")
