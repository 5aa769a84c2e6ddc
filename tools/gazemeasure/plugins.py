"""Measures inputs and modes in real time: their latency to the wipers, and effects of bad ones.

The gamepad's events are bytes of the kernel's format in a named pipe; the chair is the demo's, its
picture streaming to a viewer.
"""

from __future__ import annotations

import contextlib
import itertools
import os
import signal
import struct
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gazesetup
from gazechair.plugins.gamepad.events import ABS, REPORT, SYN, Y, event
from gazecontract.fuzz import fuzz
from gazecontract.sender_oracle import Violation
from gazedemo.check import NEUTRAL
from gazedemo.packages import package
from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.page.raw_page import RawDriver, frame, upgrade
from gazemeasure.plugins_samples import FLIP
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import STALL_S, StallProbe

_FULL, _REST = -32768, 0
_HOLD_S = 0.25
_PAUSE_S = 0.35
_PATIENCE_S = 30.0
_TRIES = 4
_MANY = 20
_NEUTRAL_MS = 300.0
_FOR_P99 = 80  # samples: with fewer, p99 is the maximum, and has no limit
_TEXT = 1
_CONFIG = """
[input.gamepad]
device = "{folder}/pad"
[mode.flips]
folder = "{folder}"
[input.bad]
folder = "{folder}"
"""


def measure(quick: bool) -> Report:
    """See the module; `quick` takes about two minutes."""
    presses = 20 if quick else 100
    report = Report("plugins: inputs and modes, from what is sensed to the wipers")
    micropython = str(gazesetup.ensure_micropython().path)
    with tempfile.TemporaryDirectory(prefix="gazechair-") as name, StallProbe() as probe:
        folder = Path(name)
        packages = _packages(folder)
        os.mkfifo(folder / "pad")
        config = _CONFIG.format(folder=folder)
        with (
            Stack(micropython, "open", more_config=config, packages=packages) as stack,
            _streaming(stack),
            RawDriver(stack.port, stack.cookie("driver", "raw")) as driver,
        ):
            bench = _Bench(stack, driver, probe, folder, report)
            bench.gamepad(presses)
            bench.mode(presses)
            bench.mode_ends()
            bench.driver_beside(presses)
        _many(report, micropython, packages)
    _fuzz(report, 30_000 if quick else 1_000_000)
    report.note("Samples that overlap a stall of the machine of over")
    report.note(f"{1000 * STALL_S:g} ms are dropped; the simulator looks at the wipers each 1 ms.")
    return report


def _packages(folder: Path) -> str:
    """Create a folder with an installed package that offers the benchmark's plug-ins."""
    home = "gazemeasure.plugins_samples"
    inputs = {"bad": f"{home}:Bad", "broken": "no_such_module_at_all:Nothing"}
    inputs |= {f"quiet{n}": f"{home}:Quiet" for n in range(_MANY - 1)}
    groups = {"gazechair.modes": {"flips": f"{home}:Flips"}, "gazechair.inputs": inputs}
    return package(folder, "gazemeasure_samples", groups)


@contextlib.contextmanager
def _streaming(stack: Stack) -> Iterator[None]:
    """A viewer that takes every picture."""
    line = upgrade(stack.port, "/ws/video", stack.cookie("viewer", "pictures"))

    def take() -> None:
        reader = line.makefile("rb")
        with contextlib.suppress(OSError, struct.error, ValueError, IndexError):
            while True:
                head = reader.read(2)
                size = head[1] & 127
                if size >= 126:
                    size = int.from_bytes(reader.read(2 if size == 126 else 8), "big")
                (number,) = struct.unpack_from("<I", reader.read(size))
                line.sendall(frame(_TEXT, str(number).encode()))

    thread = threading.Thread(target=take, name="viewer", daemon=True)
    thread.start()
    try:
        yield
    finally:
        line.close()


class _Bench:
    """The running chair and the measurements on it."""

    def __init__(
        self, stack: Stack, driver: RawDriver, probe: StallProbe, folder: Path, report: Report
    ) -> None:
        self._stack = stack
        self._driver = driver
        self._probe = probe
        self._folder = folder
        self._report = report
        self._sim: SimControl = stack.control()
        self._pad = -1

    # -- the gamepad --

    def gamepad(self, presses: int) -> None:
        """Push and release the stick, then pull the plug while it drives."""
        to_wipers: list[float] = []
        to_neutral: list[float] = []
        unplugged: list[float] = []
        for number in range(presses):
            self._plug_in()
            mark = self._begin()
            down_s = self._push(_FULL)
            time.sleep(_HOLD_S)
            if number % 5 == 4:
                up_s = self._unplug()
                into = unplugged
            else:
                up_s = self._push(_REST)
                into = to_neutral
            time.sleep(_PAUSE_S)
            self._note(mark, down_s, up_s, to_wipers, into)
        if self._pad >= 0:
            self._unplug()
        self._add("gamepad: event -> wipers", to_wipers, presses, 5.0, 20.0)
        self._add("gamepad: released -> neutral", to_neutral, presses, None, None)
        self._report.add("gamepad: unplugged -> neutral, max", max(unplugged), "ms", 100.0)

    def _plug_in(self) -> None:
        def opened() -> bool:
            if self._pad < 0:
                with contextlib.suppress(OSError):
                    self._pad = os.open(self._folder / "pad", os.O_WRONLY | os.O_NONBLOCK)
            return self._pad >= 0 and self._health("input gamepad") == "ok"

        _until(opened, "the gamepad is found")

    def _push(self, value: int) -> float:
        now_s = time.monotonic()
        os.write(self._pad, event(ABS, Y, value) + event(SYN, REPORT, 0))
        return now_s

    def _unplug(self) -> float:
        now_s = time.monotonic()
        os.close(self._pad)
        self._pad = -1
        return now_s

    # -- a mode --

    def mode(self, presses: int) -> None:
        """Hold the mode, and match its changes with the wipers'."""
        notes = self._folder / "flips"
        samples: list[float] = []
        wanted = 4 * presses
        self._ride(lambda: None)
        notes.write_text("")
        for _ in range(_TRIES):
            mark = self._ride(lambda: time.sleep(FLIP * 0.02 * presses))
            flips = [float(line) for line in notes.read_text().split()]
            notes.write_text("")
            entries = self._sim.do("wiper_log", since=mark)["entries"]
            samples += self._matched(flips, entries)
            if len(samples) >= wanted // 4:
                break
        self._add("mode at 50 Hz: sensed -> wipers", samples, presses, 10.0, None)

    def _matched(self, flips: list[float], entries: list[list[Any]]) -> list[float]:
        # The first change of the wipers after each flip; between two flips the output is constant.
        times = [
            float(b[1]) for a, b in itertools.pairwise(entries) if (a[2], a[3]) != (b[2], b[3])
        ]
        found = []
        for sensed_s in flips:
            after = [t for t in times if sensed_s < t < sensed_s + FLIP * 0.02]
            if after and not self._probe.stalled(sensed_s, after[0]):
                found.append(1000 * (after[0] - sensed_s))
        return found

    def _ride(self, act: Callable[[], None]) -> int:
        """Hold the mode's tile and do `act` while the chair moves; returns a mark in the log."""
        self._driver.button = {"k": "mode", "mode": "flips"}
        for _ in range(_TRIES):
            mark = self._begin()
            _until(lambda: self._health("mode flips") == "ok", "the mode is there")
            self._driver.press()
            with contextlib.suppress(TimeoutError):
                _until(lambda: self._sim.wipers() != NEUTRAL, "it drives", 2.0)
                act()
                break
            self._driver.release()
        self._driver.release()
        self._driver.button = {"k": "cmd", "verb": "forward", "mode": "continuous"}
        time.sleep(_PAUSE_S)
        return mark

    def mode_ends(self) -> None:
        """Kill, stop, and make it misbehave in every way while it drives."""
        for how in ("killed", "stopped", "spin", "flood", "future"):
            worst, back, kept = 0.0, 0.0, 0
            for _ in range(_TRIES):
                if kept == 2:
                    break
                ended: list[float] = []

                def act(how: str = how, ended: list[float] = ended) -> None:
                    ended.append(self._end_mode(how))
                    time.sleep(0.6)

                mark = self._ride(act)
                entries = self._sim.do("wiper_log", since=mark)["entries"]
                still = [e[1] for e in entries if e[1] >= ended[0] and (e[2], e[3]) == NEUTRAL]
                took_ms = 1000 * (still[0] - ended[0]) if still else float("inf")
                # A stall only adds delay: a sample that is in time anyway counts.
                stalled = self._probe.stalled(ended[0], ended[0] + took_ms / 1000)
                if took_ms <= _NEUTRAL_MS or not stalled:
                    worst, kept = max(worst, took_ms), kept + 1
                _until(lambda: self._health("mode flips") == "ok", "the mode is back")
                back = max(back, time.monotonic() - ended[0])
            worst = worst if kept else float("nan")
            self._report.add(f"mode {how} -> neutral, max", worst, "ms", _NEUTRAL_MS)
            self._report.add(f"mode {how}: back by itself after", back, "s")

    def _end_mode(self, how: str) -> float:
        if how in ("killed", "stopped"):
            pid = int((self._folder / "pid").read_text())
            now_s = time.monotonic()
            os.kill(pid, signal.SIGKILL if how == "killed" else signal.SIGSTOP)
            return now_s
        (self._folder / "began").unlink(missing_ok=True)
        (self._folder / how).touch()
        _until(lambda: (self._folder / "began").exists(), f"it begins to {how}", 2.0)
        time.sleep(0.01)
        return float((self._folder / "began").read_text())

    # -- the driver while an input misbehaves --

    def driver_beside(self, presses: int) -> None:
        """The driver's own presses while an input misbehaves whenever it runs."""
        calm = self._presses("", presses)
        self._add("driver alone: press, release -> wipers", calm, 2 * presses, None, None)
        for act in ("spin", "flood"):
            times = self._presses(act, presses)
            name = f"driver beside an input that {act}s"
            self._add(name, times, 2 * presses, None, None)
            grown = percentile(times, 0.99) - percentile(calm, 0.99)
            enough = min(len(times), len(calm)) >= _FOR_P99
            self._report.add(f"{name}: p99 grown by", grown, "ms", 5.0 if enough else None)

    def _presses(self, act: str, presses: int) -> list[float]:
        file = self._folder / f"bad {act}"
        if act:
            file.touch()
            _until(lambda: self._health("input bad") == "lost", "it misbehaves")
        times: list[float] = []
        try:
            for _ in range(presses):
                mark = self._begin()
                down_s = self._driver.press()
                time.sleep(_HOLD_S)
                up_s = self._driver.release()
                time.sleep(_PAUSE_S)
                self._note(mark, down_s, up_s, times, times)
        finally:
            file.unlink(missing_ok=True)
        return times

    # -- small things --

    def _begin(self) -> int:
        self._driver.arm()
        self._sim.do("teleport", x_m=0, y_m=0, heading_deg=0)
        return int(self._sim.do("wiper_log", since=0)["last"])

    def _health(self, part: str) -> str:
        return str(self._stack.health()[part]["state"])

    def _note(
        self, mark: int, down_s: float, up_s: float, moved: list[float], rested: list[float]
    ) -> None:
        entries = self._sim.do("wiper_log", since=mark)["entries"]
        first = next((e[1] for e in entries if e[1] >= down_s and (e[2], e[3]) != NEUTRAL), None)
        last = next((e[1] for e in entries if e[1] >= up_s and (e[2], e[3]) == NEUTRAL), None)
        if first is None and not self._probe.stalled(down_s, up_s):
            moved.append(float("inf"))
        if first is None or last is None or first > up_s:
            return
        for into, begin_s, end_s in ((moved, down_s, first), (rested, up_s, last)):
            if not self._probe.stalled(begin_s, end_s):
                into.append(1000 * (end_s - begin_s))

    def _add(
        self, name: str, values: list[float], of: int, median: float | None, p99: float | None
    ) -> None:
        self._report.add(f"{name}, median", percentile(values, 0.5), "ms", median)
        enough = len(values) >= _FOR_P99
        self._report.add(f"{name}, p99", percentile(values, 0.99), "ms", p99 if enough else None)
        self._report.add(f"{name}, samples", len(values), "", of * 0.3, at_least=True)


def _many(report: Report, micropython: str, packages: str) -> None:
    """Measure how much later the host is ready with twenty plug-ins, one of them broken."""
    names = [f"quiet{n}" for n in range(_MANY - 1)] + ["broken"]
    config = "\n".join(f"[input.{name}]" for name in names) + "\n"
    took_s = {}
    for count, text in ((0, ""), (_MANY, config)):
        tries = []
        for _ in range(2):
            start_s = time.monotonic()
            with Stack(micropython, "open", more_config=text, packages=packages) as stack:
                tries.append(time.monotonic() - start_s)
                if count:
                    well = _come_up(stack, names)
                    broken = stack.health()["input broken"]
        took_s[count] = min(tries)
    report.add("start without plug-ins", took_s[0], "s")
    report.add(f"{_MANY} plug-ins: start longer by", took_s[_MANY] - took_s[0], "s", 2.0)
    report.add(f"{_MANY} plug-ins, one broken: well", well, "", _MANY - 1, at_least=True)
    report.note(f"the broken one: {broken['state']}: {broken['detail']}")


def _come_up(stack: Stack, names: list[str]) -> int:
    """Wait until all plug-ins but the broken one work; returns how many do."""

    def well() -> int:
        parts = stack.health()
        return sum(parts[f"input {name}"]["state"] == "ok" for name in names)

    with contextlib.suppress(TimeoutError):
        _until(lambda: well() == len(names) - 1, "they are up")
        _until(lambda: stack.health()["input broken"]["state"] == "lost", "one is lost")
    return well()


def _fuzz(report: Report, messages: int) -> None:
    try:
        sent, judged = fuzz(messages)
        violations = 0
    except Violation as found:
        sent, judged, violations = 0, 0, 1
        report.note(f"fuzzer: {found}")
    report.add("fuzzer: messages", sent, "", messages, at_least=True)
    report.add("fuzzer: motions judged", judged, "")
    report.add("fuzzer: violations", violations, "", 0)


def _until(condition: Callable[[], bool], what: str, limit_s: float = _PATIENCE_S) -> None:
    end_s = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end_s:
            raise TimeoutError(f"waited {limit_s:g} s in vain: {what}")
        time.sleep(0.01)
