"""Measures the serial link: round trip compared with a bare echo, and replugging in every order."""

from __future__ import annotations

import os
import random
import statistics
import tempfile
import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import gazesetup
from gazeboard.core.limits import WIPER_NEUTRAL
from gazechair.base.health import OK, Health
from gazechair.board.board_commands import Clearance, Command
from gazechair.board.link import BoardLink
from gazelink import codes
from gazemeasure.far_end import far_end
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe
from gazesim.simulator import Simulator

_PINGS = 2000
_PINGS_QUICK = 300
_REPLUGS = 200
_REPLUGS_QUICK = 20
_READY_S = 20.0
_NEUTRAL = (WIPER_NEUTRAL, WIPER_NEUTRAL)
_FRAME = 14  # bytes of a PING and of a PONG
_SEED = 20261121


def measure(quick: bool) -> Report:
    """Run both; see Report."""
    pings, replugs = (_PINGS_QUICK, _REPLUGS_QUICK) if quick else (_PINGS, _REPLUGS)
    micropython = gazesetup.ensure_micropython()
    report = Report(f"link: {pings} round trips, {replugs} re-plugs")
    with (
        tempfile.TemporaryDirectory(prefix="gazechair-") as folder,
        StallProbe() as probe,
        _World(Path(folder), str(micropython.path)) as world,
    ):
        _round_trips(world, probe, pings, report)
        _replugs(world, replugs, report)
    report.note(
        f"firmware on {micropython.description}, behind the simulator's cable. Samples that"
    )
    report.note("overlap a stall of the machine are dropped. First prototype: 50 % within 1.05 ms,")
    report.note("80 % under 2 ms, outliers of 8 ms; telemetry intervals up to 4 times the period.")
    return report


class _World:
    """The simulator in its own thread, and a host link that keeps obstacle data fresh."""

    def __init__(self, folder: Path, interpreter: str) -> None:
        self._folder = folder
        self._interpreter = interpreter
        self._jobs: list[tuple[Callable[[Simulator], Any], threading.Event, list[Any]]] = []
        self._ready = threading.Event()
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="simulator", daemon=True)
        self._feeder = threading.Thread(target=self._feed, name="clearance", daemon=True)
        self.link = self._new_link()
        self.edge = 0
        self.held = (codes.STOP, codes.STEP)

    def __enter__(self) -> _World:
        self._thread.start()
        if not self._ready.wait(_READY_S):
            raise RuntimeError("the simulator does not start")
        self.link.start()
        self._feeder.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopping.set()
        self._feeder.join(5.0)
        self.link.stop()
        self._thread.join(10.0)

    def _new_link(self) -> BoardLink:
        return BoardLink(lambda: [str(self._folder / "board")], Health("board"))

    def restart_host(self) -> None:
        """End the host's link and begin a new one, like a restarted daemon."""
        self.link.stop()
        self.link = self._new_link()
        self.link.start()

    def _run(self) -> None:
        rig = Simulator(self._folder, self._interpreter, "open")
        rig.start()
        try:
            self._ready.set()
            while not self._stopping.is_set():
                rig.run(until_s=time.monotonic() + 0.01)
                while self._jobs:
                    job, done, result = self._jobs.pop(0)
                    result.append(job(rig))
                    done.set()
        finally:
            rig.stop()

    def ask(self, job: Callable[[Simulator], Any]) -> Any:
        """Run `job` in the simulator's thread; returns its result."""
        done = threading.Event()
        result: list[Any] = []
        self._jobs.append((job, done, result))
        if not done.wait(_READY_S):
            raise RuntimeError("the simulator does not answer")
        return result[0]

    def _feed(self) -> None:
        while not self._stopping.wait(0.02):
            now_s = time.monotonic()
            self.link.clearance(Clearance(0, codes.SIMULATED, now_s))
            self.link.command(Command(*self.held, self.edge, codes.DRIVER, now_s + 0.3))

    def press(self, verb: int, mode: int) -> None:
        """A new press, active until let_go()."""
        self.edge = self.edge % 255 + 1
        self.held = (verb, mode)

    def let_go(self) -> None:
        """End the request."""
        self.held = (codes.STOP, codes.STEP)

    def until(self, condition: Callable[[], bool], limit_s: float = _READY_S) -> float:
        """Seconds until `condition`; NaN when it does not become true."""
        start_s = time.monotonic()
        while not condition():
            if time.monotonic() - start_s > limit_s:
                return float("nan")
            time.sleep(0.002)
        return time.monotonic() - start_s

    def ready(self) -> bool:
        """True if connected, and nothing prevents arming."""
        state = self.link.state()
        return state is not None and state.arm_reason == codes.NO_REASON

    def armed(self) -> bool:
        """True if the board is armed."""
        state = self.link.state()
        return state is not None and state.state == codes.ARMED


# -- round trips -----------------------------------------------------------------------------------


def _round_trips(world: _World, probe: StallProbe, n: int, report: Report) -> None:
    world.until(lambda: world.link.health.state == OK)
    ours: list[float] = []
    bare: list[float] = []
    dropped = 0
    with far_end(os.write) as near:
        for _ in range(n):
            for samples, once in ((ours, world.link.ping), (bare, partial(_echoed, near))):
                start_s = time.monotonic()
                took_s: float | None = once()
                if took_s is None or probe.stalled(start_s, time.monotonic()):
                    dropped += 1
                else:
                    samples.append(1000 * took_s)
            time.sleep(0.002)
    for name, values in (("host <-> firmware", ours), ("bare pty echo", bare)):
        report.add(f"{name}, median", statistics.median(values), "ms")
        report.add(f"{name}, p95", percentile(values, 0.95), "ms")
        report.add(f"{name}, p99", percentile(values, 0.99), "ms")
    report.add("ratio of the medians", statistics.median(ours) / statistics.median(bare), "x")
    report.add("samples kept", 100 * (1 - dropped / (2 * n)), "%", 50, at_least=True)


def _echoed(near: int) -> float:
    """Time until a frame comes back from the far end."""
    start_s = time.monotonic()
    os.write(near, b"\x55" * _FRAME)
    got = 0
    while got < _FRAME:
        got += len(os.read(near, _FRAME - got))
    return time.monotonic() - start_s


# -- re-plugs --------------------------------------------------------------------------------------

_PULLS: dict[str, Callable[[Simulator], Any]] = {
    "cable": lambda rig: rig.world.faults.inject("cable_pulled"),
    "power": lambda rig: rig.world.faults.inject("board_off"),
    "reset": lambda rig: rig.world.faults.inject("board_reset"),
    "hang": lambda rig: rig.world.faults.inject("board_hang"),
}
_PLUGS: dict[str, Callable[[Simulator], Any]] = {
    "cable": lambda rig: rig.world.faults.clear("cable_pulled"),
    "power": lambda rig: rig.world.faults.clear("board_off"),
    "reset": lambda rig: None,
    "hang": lambda rig: rig.world.faults.clear("board_hang"),
}


def _replugs(world: _World, n: int, report: Report) -> None:
    chance = random.Random(_SEED)
    unwanted = not_ready = not_driving = still_moving = 0
    ready_s: list[float] = []
    for _ in range(n):
        state = chance.choice(("disarmed", "armed", "moving", "moving", "step"))
        _bring_to(world, state)
        before = world.ask(lambda rig: rig.handle({"do": "wiper_log", "since": 0})["last"])
        causes = chance.sample(sorted(_PULLS), chance.choice((1, 1, 2)))
        for cause in causes:
            world.ask(_PULLS[cause])
        if chance.random() < 0.3:
            world.restart_host()
        if chance.random() < 0.5:
            world.let_go()  # else the press stays active throughout, and must not drive
        time.sleep(chance.uniform(0.05, 0.7))
        still_moving += not _harmless(world)
        for cause in chance.sample(causes, len(causes)):
            world.ask(_PLUGS[cause])
        time.sleep(chance.uniform(0.0, 0.3))
        unwanted += _moved_again(world, before)
        world.let_go()
        took_s = world.until(world.ready)
        if took_s == took_s:
            ready_s.append(took_s)
        else:
            not_ready += 1
        unwanted += _moved_again(world, before)
        not_driving += not _drives(world)
    report.add("re-plugs", n, "", n, at_least=True)
    report.add("not neutral, relay closed, after it", still_moving, "", 0)
    report.add("unwanted wiper movements", unwanted, "", 0)
    report.add("not ready again by itself", not_ready, "", 0)
    report.add("does not drive after arming", not_driving, "", 0)
    report.add("ready again, median", statistics.median(ready_s or [float("nan")]), "s")
    report.add("ready again, max", max(ready_s or [float("nan")]), "s")


def _bring_to(world: _World, state: str) -> None:
    world.let_go()
    world.until(world.ready)
    if state == "disarmed":
        return
    _arm(world)
    if state == "moving":
        world.press(codes.FORWARD, codes.CONTINUOUS)
    elif state == "step":
        world.press(codes.LEFT, codes.STEP)
    if state != "armed":
        world.until(lambda: _wipers(world) != _NEUTRAL, 2.0)


def _arm(world: _World) -> bool:
    for _ in range(5):
        world.until(world.ready, 5.0)
        world.link.order(codes.ARM, codes.DRIVER)
        if world.until(world.armed, 1.0) < 1.0:
            return True
    return False


def _drives(world: _World) -> bool:
    # A stalled PC may cost a press; the driver presses again.
    for _ in range(5):
        if not world.armed() and not _arm(world):
            continue
        world.press(codes.FORWARD, codes.CONTINUOUS)
        if world.until(lambda: _wipers(world) != _NEUTRAL, 1.0) < 1.0:
            world.let_go()
            world.until(lambda: _wipers(world) == _NEUTRAL, 2.0)
            world.link.order(codes.DISARM, codes.DRIVER)
            return True
        world.let_go()
        time.sleep(0.1)
    return False


def _wipers(world: _World) -> tuple[int, int]:
    wipers: tuple[int, int] = world.ask(lambda rig: rig.world.wipers)
    return wipers


def _harmless(world: _World) -> bool:
    """Both wipers neutral, or the relay open: a board without power leaves the wipers unchanged."""

    def look() -> bool:
        truth = world.ask(lambda rig: rig.world.truth())
        return tuple(truth["wipers"]) == _NEUTRAL or not truth["relay_closed"]

    return world.until(look, 1.0) < 1.0


def _moved_again(world: _World, since: int) -> int:
    """Changes away from neutral after the first return to it."""
    entries = world.ask(lambda rig: rig.handle({"do": "wiper_log", "since": since})["entries"])
    neutral = False
    count = 0
    for _, _, linear, turn in entries:
        if (linear, turn) == _NEUTRAL:
            neutral = True
        elif neutral:
            count += 1
    return count
