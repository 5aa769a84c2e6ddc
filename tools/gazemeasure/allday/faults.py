"""Parts of the running demo that are killed, stopped or starved; how soon each recovers."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from gazedemo.sim_control import SimControl
from gazedemo.stack import Stack
from gazemeasure.stalls import waited_s

_LIMIT_S = 90.0
_LOOK_S = 0.05
_STARVED_S = 3.0
_SLICE_S = 0.1
_SHARE = 0.1  # share of the processor that a starved process gets
_GONE_S = 1.0  # how long a plug is out, or a device refuses
BACK_S = 5.0
"""A part that was lost is well again within this, at most."""
_STILL_S = 5.0  # how long a camera stands still: its health looks after 2 to 3 s

DAEMON = "daemon"
# The daemon's child processes, by module, and the part of /health that each is.
CHILDREN = {
    "gazechair.sensing.lidar.child": "lidar",
    "gazechair.picture.camera.child": "camera",
    "gazechair.sensing.odometry.child": "odometry",
    "gazechair.sensing.mapping.child": "map",
    "gazechair.blackbox.child": "log",
    "gazechair.alerts.child": "alerts",
    "gazechair.plugins.child": "input quiet0",
}
_WAYS = ("killed", "stopped", "starved")
# What is not a process of the host: {(part, how): (simulator's fault, how long: 0 by itself)}.
_PLUGS = {
    ("board", "cable pulled"): ("cable_pulled", _GONE_S),
    ("board", "reset"): ("board_reset", 0.0),
    ("board", "hangs, then its watchdog resets it"): ("board_hang", _GONE_S),
    ("lidar", "unplugged"): ("lidar_unplugged", _GONE_S),
    ("lidar", "silent"): ("lidar_stall", _GONE_S),
    ("camera", "refuses"): ("camera_off", _GONE_S),
    ("camera", "stands still"): ("camera_stalled", _STILL_S),
}


@dataclass(frozen=True)
class Fault:
    """A part, and what happens to it."""

    part: str
    how: str


def faults() -> list[Fault]:
    """All faults."""
    parts = [DAEMON, *CHILDREN.values()]
    return [
        *(Fault(part, how) for part in parts for how in _WAYS),
        *(Fault(*key) for key in _PLUGS),
    ]


def shuffled(dice: random.Random, count: int) -> list[Fault]:
    """`count` faults, each as often as any other, in random order."""
    found: list[Fault] = []
    while len(found) < count:
        round_ = faults()
        dice.shuffle(round_)
        found += round_
    return found[:count]


def children(pid: int) -> dict[str, int]:
    """{part: process id} of the daemon's child processes."""
    found = {}
    with contextlib.suppress(OSError):
        for task in Path(f"/proc/{pid}/task").iterdir():
            for child in (task / "children").read_text().split():
                words = Path(f"/proc/{child}/cmdline").read_bytes().decode().split("\0")
                if len(words) > 2 and words[2] in CHILDREN:
                    found[CHILDREN[words[2]]] = int(child)
    return found


def daemon_waited_s(pid: int) -> float:
    """How long the daemon, or its lidars' process, has waited for a processor: the longer time.

    Both may wait at once, so that their sum would count a second twice.
    """
    return max(waited_s(pid), waited_s(children(pid).get("lidar", 0)))


@dataclass(frozen=True)
class Well:
    """How soon a part recovered."""

    took_s: float
    """inf: never."""
    waited_s: float
    """Part of it in which its processes were ready to run, but got no processor."""
    health: str = ""
    """Its last health report, when it never recovered."""

    @property
    def own_s(self) -> float:
        """Recovery time as on an idle machine."""
        return self.took_s - self.waited_s


class Recovery:
    """Injects a fault and waits until its part has recovered."""

    def __init__(self, stack: Stack) -> None:
        self._stack = stack
        self._sim = SimControl(Path(stack.paths["control"]))

    def close(self) -> None:
        """Release the simulator's control."""
        self._sim.close()

    def of(self, fault: Fault) -> Well:
        """Inject `fault`; returns how soon its part recovers from the moment at which it can.

        That is the kill, the stop, the plug's return, or the end of starving.
        """
        if (fault.part, fault.how) in _PLUGS:
            name, lasts_s = _PLUGS[fault.part, fault.how]
            self._sim.do("inject", fault=name)
            if lasts_s:
                time.sleep(lasts_s)
                self._sim.do("clear", fault=name)
            if name == "board_hang":
                self._sim.do("inject", fault="board_reset")
            took_s = self._wait(time.monotonic(), lambda: self._state(fault.part) == "ok")
            return self._after(fault.part, took_s, 0.0)
        pid = self._pid(fault.part)
        if fault.how == "starved":
            _starve(pid)
            begun_s, before_s = time.monotonic(), self.waited_s(fault.part)
            took_s = self._wait(begun_s, lambda: self._well(fault.part, 0))
            starved_s = max(0.0, self.waited_s(fault.part) - before_s)
            return self._after(fault.part, took_s, starved_s)
        begun_s = time.monotonic()
        os.kill(pid, signal.SIGKILL if fault.how == "killed" else signal.SIGSTOP)
        took_s = self._wait(begun_s, lambda: self._well(fault.part, pid))
        return self._after(fault.part, took_s, self.waited_s(fault.part))

    def waited_s(self, part: str) -> float:
        """How long its process has waited for a processor."""
        pid = self._stack.pid("host")
        return daemon_waited_s(pid) if part == DAEMON else waited_s(children(pid).get(part, 0))

    def _pid(self, part: str) -> int:
        if part == DAEMON:
            return self._stack.pid("host")
        self._wait(time.monotonic(), lambda: part in children(self._stack.pid("host")))
        return children(self._stack.pid("host"))[part]

    def _well(self, part: str, not_pid: int) -> bool:
        if part == DAEMON:
            if self._stack.pid("host") == not_pid:
                return False
            return all(self._state(name) == "ok" for name in ("board", "lidar"))
        now = children(self._stack.pid("host")).get(part, 0)
        return now not in (0, not_pid) and self._state(part) == "ok"

    def _after(self, part: str, took_s: float, waited_s: float) -> Well:
        if took_s != float("inf"):
            return Well(took_s, waited_s)
        with contextlib.suppress(OSError, ValueError):
            return Well(took_s, waited_s, str(self._stack.health().get(part)))
        return Well(took_s, waited_s, "the host does not answer")

    def _state(self, part: str) -> str:
        return str(self._stack.health()[part]["state"])

    def _wait(self, begun_s: float, well: Callable[[], bool]) -> float:
        while time.monotonic() - begun_s < _LIMIT_S:
            # A host that is absent or just starts has not recovered yet.
            with contextlib.suppress(OSError, ValueError, KeyError):
                if well():
                    return time.monotonic() - begun_s
            time.sleep(_LOOK_S)
        return float("inf")


def _starve(pid: int) -> None:
    end_s = time.monotonic() + _STARVED_S
    with contextlib.suppress(ProcessLookupError):
        while time.monotonic() < end_s:
            os.kill(pid, signal.SIGSTOP)
            time.sleep(_SLICE_S * (1.0 - _SHARE))
            os.kill(pid, signal.SIGCONT)
            time.sleep(_SLICE_S * _SHARE)


class Background:
    """Calls `act` each `period_s` on a thread; use as a context."""

    def __init__(self, name: str, period_s: float, act: Callable[[], None]) -> None:
        self._period_s = period_s
        self._act = act
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)

    def __enter__(self) -> Background:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._stopping.set()
        self._thread.join(30.0)

    def _run(self) -> None:
        while not self._stopping.wait(self._period_s):
            with contextlib.suppress(OSError):
                self._act()


def by_part(times: Mapping[Fault, list[Well]]) -> dict[str, list[Well]]:
    """All times of each part."""
    found: dict[str, list[Well]] = {}
    for fault, values in times.items():
        found.setdefault(fault.part, []).extend(values)
    return found
