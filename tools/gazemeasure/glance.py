"""Measures from the page's event handler to the wipers, with the picture streaming."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Any

import gazesetup
from gazedemo.browser import Driver, open_page
from gazedemo.check import NEUTRAL, Check
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.report import Report, histogram, percentile
from gazemeasure.stalls import STALL_S, StallProbe

_PRESSES = 100
_PRESSES_QUICK = 25
_EDGES_MS = (2, 4, 6, 8, 10, 15, 20, 30, 50, 100)
_HOLD_S = 0.25
_REST_S = 0.45
# The time at which the page's own handlers get each event, on the computer's wall clock.
_SPY = """() => {
  window.glance = {down: 0, up: 0};
  const now = () => performance.timeOrigin + performance.now();
  addEventListener("pointerdown", () => { window.glance.down = now(); }, true);
  addEventListener("pointerup", () => { window.glance.up = now(); }, true);
}"""


@dataclass
class _Samples:
    to_wipers_ms: list[float] = field(default_factory=list)
    to_neutral_ms: list[float] = field(default_factory=list)
    dropped: int = 0
    missed: int = 0


def measure(quick: bool) -> Report:
    """Press and release Vooruit many times through a real Chromium; see Report."""
    presses = _PRESSES_QUICK if quick else _PRESSES
    micropython = gazesetup.ensure_micropython()
    chromium = gazesetup.ensure_chromium()
    with (
        Stack(str(micropython.path), "open") as stack,
        open_page(chromium, stack.invitation()) as driver,
        StallProbe() as probe,
    ):
        check = Check(stack, driver, gazesetup.LOCAL / "artefacts")
        check.simulation_is_shown()
        check.arm()
        driver.page.evaluate(_SPY)
        samples = _Samples()
        for _ in range(presses):
            _one(driver, stack.control(), probe, samples)
            if driver.data("state") != "armed":
                check.arm()
        assert driver.data("picture") == "fresh", "the picture does not stream"
    return _report(samples, presses, micropython.description)


def _one(driver: Driver, sim: SimControl, probe: StallProbe, samples: _Samples) -> None:
    sim.do("teleport", x_m=0, y_m=0, heading_deg=0)
    mark = sim.do("wiper_log", since=0)["last"]
    driver.press("forward")
    driver.page.wait_for_timeout(_HOLD_S * 1000)
    driver.release()
    driver.rest()
    driver.page.wait_for_timeout(_REST_S * 1000)
    times: dict[str, float] = driver.page.evaluate("() => window.glance")
    offset_s = time.time() - time.monotonic()
    down_s, up_s = times["down"] / 1000 - offset_s, times["up"] / 1000 - offset_s
    entries = sim.do("wiper_log", since=mark)["entries"]
    moved = _first(entries, down_s, lambda wipers: wipers != NEUTRAL)
    stopped = _first(entries, up_s, lambda wipers: wipers == NEUTRAL)
    if moved is None or stopped is None or moved > up_s:
        samples.missed += 1
        return
    if probe.stalled(down_s, moved) or probe.stalled(up_s, stopped):
        samples.dropped += 1
        return
    samples.to_wipers_ms.append(1000 * (moved - down_s))
    samples.to_neutral_ms.append(1000 * (stopped - up_s))


def _first(entries: list[list[Any]], since_s: float, wanted: Any) -> float | None:
    for _number, time_s, linear, turn in entries:
        if time_s >= since_s and wanted((linear, turn)):
            return float(time_s)
    return None


def _report(samples: _Samples, presses: int, interpreter: str) -> Report:
    report = Report(f"glance: page's handler -> wipers, picture streaming, {presses} presses")
    for name, values, limit in (
        ("press -> wipers", samples.to_wipers_ms, 10.0),
        ("let go -> neutral", samples.to_neutral_ms, 10.0),
    ):
        report.add(f"{name}, median", percentile(values, 0.5), "ms", limit)
        for share, word in ((0.95, "p95"), (0.99, "p99"), (1.0, "max")):
            report.add(f"{name}, {word}", percentile(values, share), "ms")
    report.add("samples", len(samples.to_wipers_ms), "", presses * 0.5, at_least=True)
    report.add("dropped (machine stalled)", 100 * samples.dropped / presses, "%")
    report.add("missed (refused or late)", samples.missed, "", presses * 0.05)
    report.note("press -> wipers")
    report.note(histogram(samples.to_wipers_ms, _EDGES_MS, "ms"))
    report.note("let go -> neutral")
    report.note(histogram(samples.to_neutral_ms, _EDGES_MS, "ms"))
    report.note(f"firmware on {interpreter}; samples that overlap a stall of the machine of over")
    report.note(f"{1000 * STALL_S:g} ms are dropped. The first prototype: 300 ms median.")
    return report
