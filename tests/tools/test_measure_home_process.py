"""The benchmark of odometry's process: a process that delivers late, seldom or nothing falls short.

A sleeping process stands for odometry's, and a thread here answers its scans.
"""

from __future__ import annotations

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from gazechair.sensing.odometry import inbox
from gazechair.sensing.odometry.inbox import HalfTurn
from gazechair.sensing.odometry.odometry import Estimate
from gazemeasure.home import process
from gazemeasure.report import Figure, Report


class Stub:
    """Answers one of `every` scans, `late_s` after its last measurement; `every` 0: none."""

    every, late_s = 1, 0.0

    def __init__(self, *_parts: Any) -> None:
        self._writer, self._reader = inbox.open_inbox()
        self._child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
        self._thread = threading.Thread(target=self._run, daemon=True)
        self.inbox_fd, self.pid = self._writer.fileno(), self._child.pid

    def subscribe(self, listener: Callable[[Estimate], None]) -> None:
        self._listener = listener

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._reader.shutdown(socket.SHUT_RDWR)
        self._thread.join(10.0)
        self._child.kill()
        self._child.wait()

    def _run(self) -> None:
        number = 0
        while datagram := self._reader.recv(inbox.LONGEST):
            scan = inbox.unpack(datagram)
            if not isinstance(scan, HalfTurn):
                continue
            number += 1
            if self.every and number % self.every == 0:
                late_s = max(0.0, scan.last_s + self.late_s - time.monotonic())
                arguments = scan.last_s, *(0.0,) * 6, *(0.1,) * 4, 1.0, (), 0
                threading.Timer(late_s, self._listener, [Estimate(*arguments)]).start()


@pytest.fixture
def measured(monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, Figure]]:
    """The figures of 2 s with a stub like that, by their names."""

    def measure(**like: float) -> dict[str, Figure]:
        monkeypatch.setattr(process, "OdometryService", type("Like", (Stub,), like))
        monkeypatch.setattr(process, "_SECONDS_QUICK", 2.0)
        monkeypatch.setattr(process, "_STARTS_S", 1.0)
        report = Report("home")
        process.measure(report, True, 400)
        assert report.ok is all(figure.ok for figure in report.figures)
        return {figure.name.strip(): figure for figure in report.figures}

    return measure


def short(figures: dict[str, Figure]) -> set[str]:
    return {name for name, figure in figures.items() if not figure.ok}


AGE, NUMBER = "age of an estimate, 95 %", "estimates a second"


def test_a_process_that_answers_at_once_passes(measured: Any) -> None:
    figures = measured()
    assert short(figures) == set()
    assert figures[AGE].limit == 0.15


@pytest.mark.parametrize(
    ("like", "falls_short"),
    [({"late_s": 0.4}, {AGE}), ({"every": 4}, {NUMBER}), ({"every": 0}, {AGE, NUMBER})],
)
def test_one_that_answers_late_seldom_or_never_falls_short(
    measured: Any, like: dict[str, float], falls_short: set[str]
) -> None:
    assert short(measured(**like)) == falls_short
