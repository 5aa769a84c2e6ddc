"""The lidar service end to end: the child process, rplidar-roboticia and a byte-accurate S2."""

from __future__ import annotations

import fcntl
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from gazechair.config import FootprintConfig, LidarConfig, SectorsConfig
from gazechair.health import Health
from gazechair.lidar import LidarService
from gazechair.outgoing import Clearance
from gazelink import codes
from gazesim.pty_port import PtyPort
from gazesim.s2 import S2

LONG_S = 60.0
BACKWARD = 1 << codes.DIR_BACKWARD
FORWARD = 1 << codes.DIR_FORWARD


class Rig:
    """An S2 in a round room on a pty, pumped in real time, and what the service publishes."""

    def __init__(self, path: Path) -> None:
        self.front_m = 3.0
        self.device = S2(self._range)
        self.port = PtyPort(path)
        self.port.plug()
        self.babble = b""
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._pump, name="rig", daemon=True)
        self._thread.start()
        self.published: list[tuple[int, int, float]] = []
        self.states: list[str] = []
        self.health = Health("lidar", on_change=self._note_state)
        self.service = LidarService(
            (LidarConfig(kind="s2", port=str(path)),),
            SectorsConfig(),
            FootprintConfig(),
            self._publish,
            self.health,
        )

    def _range(self, angles: np.ndarray) -> np.ndarray:
        degrees = np.degrees(angles) % 360.0
        ahead = (degrees < 10.0) | (degrees > 350.0)
        return np.where(ahead, self.front_m, 3.0)

    def _note_state(self) -> None:
        self.states.append(self.health.state)

    def _publish(self, clearance: Clearance) -> None:
        self.published.append((clearance.blocked, clearance.source, clearance.acquired_s))

    def _pump(self) -> None:
        last_s = time.monotonic()
        while not self._stop.wait(0.004):
            self.device.receive(self.port.read())
            now_s = time.monotonic()
            # As the cable: a stalled test machine pauses the lidar, it does not flood the host.
            data = self.device.step(min(now_s - last_s, 0.02))
            last_s = now_s
            if self.port.plugged:
                self.port.write(self.babble or data)

    def close(self) -> None:
        self.service.stop()
        self._stop.set()
        self._thread.join(5.0)
        self.port.unplug()

    def wait(self, condition: Callable[[], bool]) -> None:
        deadline_s = time.monotonic() + LONG_S
        while not condition():
            assert time.monotonic() < deadline_s, self.health.now()
            time.sleep(0.02)

    def wait_fresh(self, blocked: int) -> None:
        """Until something acquired from now on says `blocked`."""
        now_s = time.monotonic()
        self.wait(lambda: bool(self.published) and self.published[-1][2] > now_s)
        self.wait(lambda: self.published[-1][0] == blocked)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path / "lidar")
    yield rig
    rig.close()


def test_flags_and_source_are_published_and_follow_the_room(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh(BACKWARD)
    assert rig.health.state == "ok"
    assert {source for _, source, _ in rig.published} == {codes.SIMULATED}
    rig.front_m = 0.4
    rig.wait_fresh(BACKWARD | FORWARD)
    rig.front_m = 3.0
    rig.wait_fresh(BACKWARD)


def test_acquisition_is_never_later_than_the_scan_and_always_goes_on(rig: Rig) -> None:
    rig.service.start()
    rig.wait(lambda: len(rig.published) > 30)
    times_s = [acquired_s for _, _, acquired_s in rig.published]
    assert times_s[-1] <= time.monotonic() - 0.05
    assert times_s[-1] > times_s[0]


def test_a_killed_child_is_replaced(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh(BACKWARD)
    pid = rig.service.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    rig.wait(lambda: rig.service.restarts == 1)
    rig.wait_fresh(BACKWARD)
    assert rig.health.state == "ok"


def test_a_hanging_child_is_killed_and_replaced(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh(BACKWARD)
    pid = rig.service.pid
    assert pid is not None
    os.kill(pid, signal.SIGSTOP)
    rig.wait(lambda: rig.health.state == "lost")
    rig.wait_fresh(BACKWARD)


def test_a_pulled_cable_is_said_and_healed(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh(BACKWARD)
    rig.port.unplug()
    rig.wait(lambda: rig.health.state == "lost")
    assert rig.health.reason == "lidar_lost"
    count = len(rig.published)
    rig.wait(lambda: "there is no port" in rig.health.detail)
    assert len(rig.published) == count
    rig.device.power_on()
    rig.port.plug()
    rig.wait_fresh(BACKWARD)
    rig.wait(lambda: rig.health.state == "ok")
    since_lost = rig.states[rig.states.index("lost") :]
    assert set(since_lost) == {"lost", "ok"}, "attempts to reopen are no news"


def test_a_port_that_another_program_holds_is_said(rig: Rig) -> None:
    with rig.port.path.open("rb", buffering=0) as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        rig.service.start()
        rig.wait(lambda: "used by another program" in rig.health.detail)
    rig.wait_fresh(BACKWARD)


def test_a_stalled_stream_publishes_nothing_and_is_said(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh(BACKWARD)
    rig.device.stalled = True
    rig.wait(lambda: rig.health.state == "lost")
    count = len(rig.published)
    rig.wait(lambda: "no RPLIDAR answers" in rig.health.detail)
    assert len(rig.published) == count
    rig.device.stalled = False
    rig.wait_fresh(BACKWARD)


def test_a_blocked_mirror_is_said(rig: Rig) -> None:
    rig.device.mirror_blocked = True
    rig.service.start()
    rig.wait(lambda: "no measurements" in rig.health.detail)
    assert rig.published == []


def test_protection_stop_is_said(rig: Rig) -> None:
    rig.device.protection_stop = True
    rig.service.start()
    rig.wait(lambda: "does not start" in rig.health.detail)


def test_lost_and_corrupt_bytes_are_lived_with(rig: Rig) -> None:
    rig.device.drop = 1e-4
    rig.device.corrupt = 1e-4
    rig.service.start()
    rig.wait(lambda: rig.service.report is not None and rig.service.report.lidars[0].resyncs > 5)
    assert rig.service.restarts == 0
    rig.wait_fresh(BACKWARD)


def test_a_port_where_something_else_talks_is_refused_in_one_line(rig: Rig) -> None:
    rig.babble = b"\x55\xaa\x01" * 20
    rig.service.start()
    rig.wait(lambda: rig.health.state == "lost")
    assert "lidar.port" in rig.health.detail
    assert "\n" not in rig.health.detail


def test_a_view_covered_ahead_is_degraded_and_blocked(rig: Rig) -> None:
    rig._range = lambda angles: np.full(len(angles), np.inf)  # type: ignore[method-assign]
    rig.device = S2(rig._range)
    rig.service.start()
    rig.wait(lambda: rig.health.state == "degraded")
    assert rig.health.reason == "lidar_view"
    assert "blind at" in rig.health.detail
    assert all(blocked == 0b1111 for blocked, _, _ in rig.published)


def test_without_a_lidar_the_health_says_what_to_do() -> None:
    health = Health("lidar")
    service = LidarService(
        (LidarConfig(),), SectorsConfig(), FootprintConfig(), lambda _: None, health
    )
    service.start()
    service.stop()
    assert (health.state, health.reason) == ("lost", "lidar_lost")
    assert "lidar.kind" in health.detail


def test_stopping_stops_the_motor_and_ends_the_process(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh(BACKWARD)
    pid = rig.service.pid
    assert pid is not None
    rig.service.stop()
    rig.wait(lambda: not rig.device.scanning)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
