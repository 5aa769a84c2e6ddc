"""The lidar service end to end: the child process, rplidar-roboticia and a byte-accurate S2."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from gazechair.base.health import DEGRADED, LOST, OK, STARTING, Health
from gazechair.board.board_commands import Clearance
from gazechair.config.settings import FootprintConfig, LidarConfig
from gazechair.sensing.lidar import LidarService
from gazechair.sensing.lidar.report import LidarReport, Report
from gazelink import codes
from gazesim.zone import reported_zone
from lidarrig import LidarRig, wait_for

NEAR_MM = 1000
MASK = ((123.0, -123.0),)  # where the simulated lidar sees its own chair


class Rig(LidarRig):
    """The lidar, the service that reads it, and what that publishes."""

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self.published: list[Clearance] = []
        self.states: list[str] = []
        self.health = Health("lidar", on_change=self._note_state)
        self.service = LidarService(
            (LidarConfig(kind="s2", port=str(path), mask=MASK),),
            FootprintConfig(),
            self._publish,
            self.health,
        )
        self.service.zone(reported_zone())

    def _note_state(self) -> None:
        self.states.append(self.health.state)

    def _publish(self, clearance: Clearance) -> None:
        self.published.append(clearance)

    def close(self) -> None:
        self.service.stop()
        super().close()

    def wait(self, condition: Callable[[], bool]) -> None:
        wait_for(condition, self.health.now)

    def wait_fresh(self, near: bool = False) -> None:
        """Wait for data acquired from now on, with something near ahead or not."""
        now_s = time.monotonic()
        self.wait(lambda: bool(self.published) and self.published[-1].acquired_s > now_s)
        self.wait(lambda: (self.published[-1].forward_mm < NEAR_MM) == near)


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Rig]:
    rig = Rig(tmp_path / "lidar")
    yield rig
    rig.close()


def test_distances_and_source_are_published_and_follow_the_room(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh()
    assert rig.health.state == "ok"
    assert {each.source for each in rig.published} == {codes.SIMULATED}
    assert "turns/s, sees 100% of its view" in rig.service.describe()
    rig.front_m = 0.4
    rig.wait_fresh(near=True)
    rig.front_m = 3.0
    rig.wait_fresh()


def test_a_killed_child_is_replaced(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh()
    pid = rig.service.pid
    assert pid is not None
    os.kill(pid, signal.SIGKILL)
    rig.wait(lambda: rig.service.restarts == 1)
    rig.wait_fresh()
    assert rig.health.state == "ok"


def test_a_pulled_cable_is_said_and_healed(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh()
    rig.unplug()
    rig.wait(lambda: rig.health.state == "lost")
    assert rig.health.reason == "lidar_lost"
    count = len(rig.published)
    rig.wait(lambda: "there is no port" in rig.health.detail)
    assert len(rig.published) == count
    rig.plug()
    rig.wait_fresh()
    rig.wait(lambda: rig.health.state == "ok")
    since_lost = rig.states[rig.states.index("lost") :]
    assert set(since_lost) == {"lost", "ok"}, "attempts to reopen are no news"


def test_a_view_covered_ahead_is_degraded_and_blocked(rig: Rig) -> None:
    rig.device.beams.covered_deg = (-120.0, 120.0)
    rig.service.start()
    rig.wait(lambda: rig.health.state == "degraded")
    assert rig.health.reason == "lidar_view"
    assert "blind at" in rig.health.detail
    assert rig.published
    assert all(each.blocked & 0b1101 == 0b1101 for each in rig.published)


def test_without_a_lidar_the_health_says_what_to_do() -> None:
    health = Health("lidar")
    service = LidarService((LidarConfig(),), FootprintConfig(), lambda _: None, health)
    service.start()
    service.stop()
    assert (health.state, health.reason) == ("lost", "lidar_lost")
    assert "lidar.kind" in health.detail


def test_of_two_the_lost_one_is_told_and_the_other_counts() -> None:
    health = Health("lidar")
    both = tuple(LidarConfig(name=name, kind="s2") for name in ("front", "rear"))
    service = LidarService(both, FootprintConfig(), lambda _: None, health)

    def hear(*states: str) -> tuple[str, str]:
        ones = (
            LidarReport(name, state, "ok" if state == OK else "lidar_lost", "no such port")
            for name, state in zip(("front", "rear"), states, strict=True)
        )
        service._on_data(Report(tuple(ones), None, None).pack())
        return health.state, health.reason

    assert hear(OK, LOST) == (DEGRADED, "lidar_one")
    assert health.detail == "rear: no such port"
    assert hear(LOST, LOST) == (LOST, "lidar_lost")
    assert hear(LOST, STARTING) == (LOST, "lidar_lost")
    assert hear(OK, OK) == (OK, "ok")


def test_what_is_new_is_published_though_the_oldest_measurement_is_the_same() -> None:
    reported: list[Clearance] = []
    lidars = (LidarConfig(kind="s2"),)
    service = LidarService(lidars, FootprintConfig(), reported.append, Health("lidar"))
    for forward_mm, acquired_s in ((5000, 1.0), (300, 1.0), (300, 1.0), (300, 1.1)):
        found = {"blocked": 0, "forward_mm": forward_mm}
        service._on_data(Report((LidarReport("front", OK, "ok", ""),), acquired_s, 1, found).pack())
    assert [(one.forward_mm, one.acquired_s) for one in reported] == [
        (5000, 1.0),
        (300, 1.0),
        (300, 1.1),
    ]


def test_stopping_stops_the_motor_and_ends_the_process(rig: Rig) -> None:
    rig.service.start()
    rig.wait_fresh()
    pid = rig.service.pid
    assert pid is not None
    rig.service.stop()
    rig.wait(lambda: not rig.device.scanning)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
