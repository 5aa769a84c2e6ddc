"""Measures the driver's page in a real Chromium on a bad network: delay, picture age, load.

Both sockets go through one shaper (see shaper). The driver is a pointer that rests on Vooruit, like
gaze, and jitters at 30 Hz; times are those at which the page's own handlers ran.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import gazesetup
from gazedemo.browser import Driver, open_page
from gazedemo.check import Check
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.page import floods
from gazemeasure.page.frozen_viewer import FrozenViewer
from gazemeasure.page.page_spy import TAKE, install
from gazemeasure.page.shaper import Shaper
from gazemeasure.page.stamped_camera import StampedCamera
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import STALL_S, StallProbe

_HOLD_S = 0.3
_REST_S = 0.7
_JITTER_S = 0.033
_SETTLE_S = 6.0  # until the picture's size has settled
_WAIT_S = 5.0
_PATIENCE = 3  # times as many presses at most
_THROTTLE = 6
_WEIGHT_LIMIT_KB = 40.0
_BUSY_LIMIT_PERCENT = 30.0
_PICTURE_LIMIT_MS = 250.0
_GROWTH_LIMIT_MS = 100.0


@dataclass(frozen=True)
class Network:
    """One shape, the same in both directions, and the limits of the time that it may add."""

    name: str
    mbit_s: float
    delay_ms: float
    may_add_ms: float


GOOD = Network("2 Mbit/s", 2.0, 0.0, 0.0)
BAD = Network("0.3 Mbit/s, +100 ms each way", 0.3, 100.0, 100.0)


@dataclass
class Samples:
    """The samples of one network, ms."""

    to_wipers: list[float] = field(default_factory=list)
    to_neutral: list[float] = field(default_factory=list)
    event_delay: list[float] = field(default_factory=list)
    drawn_age: list[float] = field(default_factory=list)
    shown_age: list[float] = field(default_factory=list)
    widths: list[int] = field(default_factory=list)
    pressed: int = 0
    dropped: int = 0
    missed: int = 0


def measure(quick: bool) -> Report:
    """See the module; `quick` takes about two minutes, the whole about 20."""
    presses = 12 if quick else 60
    report = Report("page: the driver's page in Chromium on a bad network")
    micropython = gazesetup.ensure_micropython()
    with (
        _camera() as camera,
        StallProbe() as probe,
        Stack(str(micropython.path), "open", camera_url=camera.url) as stack,
        Shaper(stack.port) as shaper,
    ):
        _judge_glances(report, stack, shaper, probe, presses)
        floods.judge(report, stack, probe, 4 if quick else 12)
        _judge_long(report, stack, shaper, 60.0 if quick else 600.0)
        _judge_load(report, stack, 15.0 if quick else 60.0)
    report.note("entered: the page's handler when the dwell is over -> wipers leave neutral.")
    report.note("left: the page's handler of the pointer leaving -> neutral, less the grace.")
    report.note("picture age: read from a stamp in the picture itself, when it is drawn and as it")
    report.note("  is shown until the next one. One token bucket per direction, 64 kB buffer.")
    report.note("floods: four connections of one attacker each; the driver is a program's page.")
    report.note(f"Samples that overlap a stall of the machine of over {1000 * STALL_S:g} ms are")
    report.note(f"  dropped. Firmware on {micropython.description}.")
    return report


@contextlib.contextmanager
def _camera() -> Iterator[StampedCamera]:
    camera = StampedCamera()
    camera.start()
    try:
        yield camera
    finally:
        camera.stop()


@contextlib.contextmanager
def _page(stack: Stack, port: int | None = None, spy: bool = True) -> Iterator[Driver]:
    """The paired driver's page, through `port` when one is given, armed."""
    chromium = gazesetup.ensure_chromium()
    address = stack.invitation()
    if port is not None:
        _, _, path = address.partition("//")[2].partition("/")
        address = f"http://127.0.0.1:{port}/{path}"
    with open_page(chromium, address) as driver:
        if spy:
            install(driver.page)
        yield driver


def _judge_glances(
    report: Report, stack: Stack, shaper: Shaper, probe: StallProbe, presses: int
) -> None:
    port = stack.port
    for network, frozen in ((GOOD, False), (GOOD, True), (BAD, False)):
        shaper.shape(network.mbit_s, network.delay_ms)
        name = network.name + (", a frozen viewer beside" if frozen else "")
        with contextlib.ExitStack() as viewers, _page(stack, shaper.port) as driver:
            if frozen:
                viewers.enter_context(FrozenViewer(port, stack.cookie("viewer", "frozen")))
            samples = _glances(driver, stack, probe, presses)
        _report_glances(report, name, network, samples, presses)
        if network is GOOD and not frozen:
            age = percentile(samples.drawn_age, 0.95)
            report.add(f"{name}: picture age when drawn, p95", age, "ms", _PICTURE_LIMIT_MS)
            age = percentile(samples.shown_age, 0.95)
            report.add(f"{name}: picture age while shown, p95", age, "ms", _PICTURE_LIMIT_MS)
        report.add(f"{name}: picture width, median", percentile(samples.widths, 0.5), "px")


def _glances(driver: Driver, stack: Stack, probe: StallProbe, presses: int) -> Samples:
    check = Check(stack, driver, gazesetup.LOCAL / "artefacts")
    check.simulation_is_shown()
    driver.page.wait_for_timeout(_SETTLE_S * 1000)
    grace_ms = _grace_ms(driver)
    samples = Samples()
    driver.page.evaluate(TAKE)
    while samples.pressed < presses or (
        len(samples.to_wipers) < presses * floods.ENOUGH and samples.pressed < _PATIENCE * presses
    ):
        if driver.data("state") != "armed":
            check.arm()
        samples.pressed += 1
        _one(driver, stack.control(), probe, grace_ms, samples)
    return samples


def _one(
    driver: Driver, sim: SimControl, probe: StallProbe, grace_ms: float, samples: Samples
) -> None:
    sim.do("teleport", x_m=0, y_m=0, heading_deg=0)
    mark = sim.do("wiper_log", since=0)["last"]
    _rest(driver, 0.5)
    start_s = time.monotonic()
    while driver.page.evaluate("() => window.spy.sent.length") == 0:
        _look(driver, "forward", _JITTER_S)
        if time.monotonic() - start_s > _WAIT_S:
            break
    _look(driver, "forward", _HOLD_S)
    _rest(driver, _REST_S)
    seen: dict[str, Any] = driver.page.evaluate(TAKE)
    samples.event_delay += seen["late"]
    _ages(seen["drawn"], samples)
    offset_s = time.time() - time.monotonic()
    sent = [at / 1000 - offset_s for at in seen["sent"]]
    left = [at / 1000 - offset_s for at, name in seen["over"] if name == ""]
    entries = sim.do("wiper_log", since=mark)["entries"]
    moved = floods.first(entries, sent[0], moved=True) if sent else None
    left = [at for at in left if moved is not None and at > moved]
    stopped = floods.first(entries, left[0], moved=False) if left else None
    if moved is None or stopped is None:
        samples.missed += 1
    elif probe.stalled(sent[0], moved) or probe.stalled(left[0], stopped):
        samples.dropped += 1
    else:
        samples.to_wipers.append(1000 * (moved - sent[0]))
        samples.to_neutral.append(1000 * (stopped - left[0]) - grace_ms)


def _look(driver: Driver, target: str, seconds: float) -> None:
    """Rest the pointer on a target, jittering like gaze."""
    box = driver.page.locator(f"#{target}").bounding_box()
    assert box is not None, f"the page shows no target {target!r}"
    _jitter(driver, box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, seconds)


def _rest(driver: Driver, seconds: float) -> None:
    size = driver.page.viewport_size
    assert size is not None
    _jitter(driver, size["width"] * 0.5, size["height"] * 0.6, seconds)


def _jitter(driver: Driver, x: float, y: float, seconds: float) -> None:
    end_s = time.monotonic() + seconds
    step = 0
    while True:
        step += 1
        driver.page.mouse.move(x + step % 3, y + step % 2)
        if time.monotonic() >= end_s:
            return
        driver.page.wait_for_timeout(_JITTER_S * 1000)


def _grace_ms(driver: Driver) -> float:
    answer: dict[str, Any] = driver.page.evaluate("async () => (await fetch('/profiles')).json()")
    mine = next(each for each in answer["profiles"] if each["id"] == answer["chosen"])
    return float(mine["leave_grace_ms"])


def _ages(drawn: list[list[float]], samples: Samples) -> None:
    """Add the ages when drawn, and every 10 ms until the next picture is drawn."""
    for index, (at_ms, age_ms, width) in enumerate(drawn):
        samples.drawn_age.append(age_ms)
        samples.widths.append(int(width))
        if index + 1 < len(drawn):
            shown_ms = int(drawn[index + 1][0] - at_ms)
            samples.shown_age += [age_ms + more for more in range(0, shown_ms, 10)]


def _report_glances(
    report: Report, name: str, network: Network, samples: Samples, presses: int
) -> None:
    add = network.may_add_ms
    entered, left = samples.to_wipers, samples.to_neutral
    report.add(f"{name}: entered -> wipers, median", percentile(entered, 0.5), "ms", 10 + add)
    report.add(f"{name}: entered -> wipers, p99", percentile(entered, 0.99), "ms", 50 + add)
    report.add(f"{name}: left -> neutral, median", percentile(left, 0.5), "ms")
    report.add(f"{name}: left -> neutral, p95", percentile(left, 0.95), "ms", 50 + add)
    delay = percentile(samples.event_delay, 0.95)
    report.add(f"{name}: browser's event delay, p95", delay, "ms")
    report.add(f"{name}: samples", len(entered), "", presses * floods.ENOUGH, at_least=True)
    report.add(f"{name}: dropped (stalls)", 100 * samples.dropped / samples.pressed, "%")
    report.add(f"{name}: missed", samples.missed, "", max(1.0, samples.pressed * 0.05))


def _judge_long(report: Report, stack: Stack, shaper: Shaper, seconds: float) -> None:
    """Check the picture on the bad network: its age is bounded and does not grow."""
    shaper.shape(BAD.mbit_s, BAD.delay_ms)
    samples = Samples()
    thirds: list[list[float]] = [[], [], []]
    with _page(stack, shaper.port) as driver:
        driver.wait(lambda: driver.data("picture") != "none", 30, "a picture is shown")
        driver.page.wait_for_timeout(_SETTLE_S * 1000)
        driver.page.evaluate(TAKE)
        for third in thirds:
            samples.drawn_age.clear()
            driver.page.wait_for_timeout(seconds / 3 * 1000)
            _ages(driver.page.evaluate(TAKE)["drawn"], samples)
            third += samples.drawn_age
    report.add(f"{BAD.name}: picture age when drawn, p95", percentile(thirds[2], 0.95), "ms")
    report.add(f"{BAD.name}: picture age, oldest", max(map(max, thirds)), "ms", 2000)
    growth = percentile(thirds[2], 0.5) - percentile(thirds[0], 0.5)
    report.add(f"{BAD.name}: growth over {seconds:g} s", growth, "ms", _GROWTH_LIMIT_MS)
    report.add(f"{BAD.name}: pictures a second", sum(map(len, thirds)) / seconds, "")
    report.add(f"{BAD.name}: most in the buffer", shaper.down.most_waiting / 1000, "kB", 64)


def _judge_load(report: Report, stack: Stack, seconds: float) -> None:
    """Measure the page's size, and the main thread's load on a processor six times slower."""
    sizes: dict[str, int] = {}
    with _page(stack, spy=False) as driver:
        session = driver.page.context.new_cdp_session(driver.page)
        session.send("Network.enable")
        session.send("Network.setCacheDisabled", {"cacheDisabled": True})
        driver.page.on("requestfinished", lambda asked: sizes.__setitem__(asked.url, _size(asked)))
        driver.page.reload()
        Check(stack, driver, gazesetup.LOCAL / "artefacts").arm()
        # By its own processor time: what waits for a processor is no load of the page's.
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        session.send("Emulation.setCPUThrottlingRate", {"rate": _THROTTLE})
        begin_s, begin = time.monotonic(), _task_s(session)
        while time.monotonic() - begin_s < seconds:
            _look(driver, "left", 1.5)
            _rest(driver, 0.5)
        busy = 100 * (_task_s(session) - begin) / (time.monotonic() - begin_s)
        session.send("Emulation.setCPUThrottlingRate", {"rate": 1})
    weight = sum(sizes.values()) / 1000
    report.add("page weight without the picture", weight, "kB", _WEIGHT_LIMIT_KB)
    report.add("files", len(sizes), "")
    report.add(f"main thread busy, CPU / {_THROTTLE}", busy, "%", _BUSY_LIMIT_PERCENT)


def _size(asked: Any) -> int:
    """Bytes of the answer's body on the line."""
    with contextlib.suppress(Exception):  # sockets and redirects have none
        return int(asked.sizes()["responseBodySize"])
    return 0


def _task_s(session: Any) -> float:
    metrics = session.send("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in metrics if each["name"] == "TaskDuration"))
