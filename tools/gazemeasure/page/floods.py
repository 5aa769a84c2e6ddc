"""The driver's times under each flood of the table: press -> wipers, release -> neutral; memory."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import gazesetup
from gazedemo.check import NEUTRAL
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.page.flooding import ATTACKS
from gazemeasure.page.raw_page import RawDriver
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe

_HOLD_S = 0.25
_REST_S = 0.35
_BUILD_UP_S = 1.0
_MOST_MS = 50.0
_GROWTH_MB = 20.0
ENOUGH = 0.4
"""Share of the presses that must have met no stall of the machine."""
_PATIENCE = 4  # times as many presses at most


@dataclass
class _Times:
    """The times during one attack, ms."""

    both: list[float] = field(default_factory=list)
    pressed: int = 0
    missed: int = 0
    dropped: int = 0


def judge(report: Report, stack: Stack, probe: StallProbe, presses: int) -> None:
    """Add a line for each attack, and one for none."""
    viewer = stack.cookie("viewer", "flood")
    name, _, _ = viewer.partition("=")
    with RawDriver(stack.port, stack.cookie("driver", "raw")) as driver:
        for attack in ("", *ATTACKS):
            before_mb = _memory_mb(stack)
            with _attacked(stack, attack, name, viewer):
                times = _drive(driver, stack.control(), probe, presses)
            grown_mb = _memory_mb(stack) - before_mb
            _add(report, attack or "no flood", times, before_mb, grown_mb)


def _add(report: Report, attack: str, times: _Times, before_mb: float, grown_mb: float) -> None:
    report.add(f"{attack}: driver, median", percentile(times.both, 0.5), "ms")
    report.add(f"{attack}: driver, max", percentile(times.both, 1.0), "ms", _MOST_MS)
    report.add(f"{attack}: missed", times.missed, "", max(1.0, times.pressed * 0.05))
    report.add(f"{attack}: dropped (stalls)", 100 * times.dropped / times.pressed, "%")
    report.add(f"{attack}: memory before", before_mb, "MB")
    report.add(f"{attack}: memory grown by", grown_mb, "MB", _GROWTH_MB)


@contextlib.contextmanager
def _attacked(stack: Stack, attack: str, cookie_name: str, cookie: str) -> Iterator[None]:
    if not attack:
        yield
        return
    words = [attack, str(stack.port), cookie_name, cookie]
    with subprocess.Popen(
        [sys.executable, "-m", "gazemeasure.page.flooding", *words],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        env=gazesetup.source_environment(),
    ) as process:
        time.sleep(_BUILD_UP_S)
        try:
            yield
            if process.poll() is not None:
                raise RuntimeError(f"{attack}: the attack ended by itself")
        finally:
            process.kill()


def _drive(driver: RawDriver, sim: SimControl, probe: StallProbe, presses: int) -> _Times:
    times = _Times()
    while times.pressed < presses or (
        len(times.both) < 2 * presses * ENOUGH and times.pressed < _PATIENCE * presses
    ):
        driver.arm()
        sim.do("teleport", x_m=0, y_m=0, heading_deg=0)
        mark = sim.do("wiper_log", since=0)["last"]
        times.pressed += 1
        down_s = driver.press()
        time.sleep(_HOLD_S)
        up_s = driver.release()
        time.sleep(_REST_S)
        entries = sim.do("wiper_log", since=mark)["entries"]
        moved_s = first(entries, down_s, moved=True)
        stopped_s = first(entries, up_s, moved=False)
        if moved_s is None or stopped_s is None or moved_s > up_s:
            # The chair refuses to move on late scans, as on a machine that stalls.
            stalled = probe.stalled(down_s - _REST_S, up_s + _REST_S)
            times.missed += not stalled
            times.dropped += stalled
            continue
        for begin_s, end_s in ((down_s, moved_s), (up_s, stopped_s)):
            if not probe.stalled(begin_s, end_s):
                times.both.append(1000 * (end_s - begin_s))
    return times


def first(entries: list[list[Any]], since_s: float, moved: bool) -> float | None:
    """When the wipers first left neutral (`moved`), or were back there, after `since_s`."""
    for _number, time_s, linear, turn in entries:
        if time_s >= since_s and ((linear, turn) != NEUTRAL) == moved:
            return float(time_s)
    return None


def _memory_mb(stack: Stack) -> float:
    status = Path(f"/proc/{stack.pid('host')}/status").read_text()
    line = next(line for line in status.splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1000
