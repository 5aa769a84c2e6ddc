"""Odometry as a process, the service around it, and what becomes of its estimates."""

from __future__ import annotations

import json
import math
import os
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from types import SimpleNamespace

import pytest

from gazechair.base.health import Health
from gazechair.base.latest_value import Entry
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.doubts import CORRIDOR, PUSHED, STUCK
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.service import OdometryService
from gazechair.sensing.odometry.shown import shown
from gazelink import codes
from host.sensing.test_inbox import FRONT, half_turn
from lidarrig import wait_for


@pytest.fixture
def service() -> Iterator[OdometryService]:
    obeys = Obeys(Health("motion"), lambda: None)
    made = OdometryService((FRONT,), Health("odometry"), obeys)
    made.start()
    yield made
    made.stop()


def feed(service: OdometryService, seconds: float) -> None:
    """Send the data of a standing chair."""
    end_s, second = time.monotonic() + seconds, False
    while time.monotonic() < end_s:
        now_s = time.monotonic()
        inbox.send(service.inbox_fd, inbox.pack_motion(Motion(now_s, 90.0, 0, 0)))
        inbox.send(service.inbox_fd, inbox.pack_scan(half_turn(now_s, second=second)))
        second = not second
        time.sleep(0.05)


def test_the_process_estimates_and_comes_back_when_it_is_killed(service: OdometryService) -> None:
    heard: list[Estimate] = []
    service.subscribe(heard.append)
    health = service._health

    def estimated() -> bool:
        feed(service, 0.2)
        return service.latest.get() is not None

    wait_for(estimated, lambda: str(health.now()))
    assert heard
    assert health.now().state == "ok"
    entry = service.latest.entry()
    assert entry is not None
    assert math.hypot(entry.value.x_m, entry.value.y_m) < 0.01
    assert entry.born_s == entry.value.time_s
    assert abs(entry.value.time_s - time.monotonic()) < 1.0
    assert service.pid is not None
    os.kill(service.pid, signal.SIGKILL)
    wait_for(lambda: service.latest.get() is None, lambda: str(health.now()))
    assert (health.now().state, health.now().reason) == ("lost", "odometry_lost")
    wait_for(estimated, lambda: str(health.now()))
    assert service.restarts >= 1
    again = service.latest.get()
    assert again is not None
    assert again.track > entry.value.track  # its places have nothing to do with those before


def test_what_is_old_or_doubted_is_not_shown() -> None:
    known = Estimate(10.0, 0.0, 0.0, 0.0, 0.4, 0.0, 3.0, 0.1, 0.1, 1.0, 0.02, 0.9, (), 0)
    told = {"m_s": 0.4, "deg_s": 3.0, "sigma_m_s": 0.02, "age_s": 0.2}
    assert shown(Entry(known, 10.0, 1), 10.2) == told
    assert shown(None, 10.2) is None
    assert shown(Entry(known, 10.0, 1), 10.6) is None
    assert shown(Entry(replace(known, speed_sigma_m_s=0.3), 10.0, 1), 10.2) is None
    assert shown(Entry(replace(known, doubts=(CORRIDOR,)), 10.0, 1), 10.2) is None
    assert shown(Entry(replace(known, doubts=(PUSHED,)), 10.0, 1), 10.2) == told


def test_a_lidar_that_may_be_turned_is_named_at_once_and_no_longer_than_it_is() -> None:
    health = Health("odometry")
    lidars = replace(FRONT, name="front"), replace(FRONT, name="rear")
    service = OdometryService(lidars, health, Obeys(Health("motion"), lambda: None))
    for turned, reason in ((None, "ok"), (1, "lidar_turned"), (None, "ok")):
        known = Estimate(1.0, 0.0, 0.0, 0.0, 0.4, 0.0, 3.0, 0.1, 0.1, 1.0, 0.02, 0.9, (), 0)
        known = replace(known, turned_lidar=turned)
        service._on_data(json.dumps(asdict(known)).encode())
        assert health.now().reason == reason
        assert health.now().detail.endswith("rear or front") is (turned is not None)
        assert health.now().about == ("" if turned is None else "rear / front")
    known = replace(known, turned_lidar=1, turned_by_walls=True)
    service._on_data(json.dumps(asdict(known)).encode())
    assert health.now().detail.endswith(": rear")
    assert health.now().about == "rear"


def test_stuck_and_uncommanded_motion_are_health_while_driving_is_on() -> None:
    health, board = Health("motion"), SimpleNamespace(state=codes.DISARMED)
    obeys = Obeys(health, lambda: board)  # type: ignore[arg-type, return-value]

    def judged(time_s: float, *doubts: str) -> str:
        known = Estimate(time_s, 0.0, 0.0, 0.0, 0.4, 0.0, 3.0, 0.1, 0.1, 1.0, 0.02, 0.9, doubts, 0)
        obeys.judge(known)
        return health.now().reason

    assert judged(1.0, PUSHED) == "ok"  # driven by hand
    board.state = codes.ARMED
    assert [judged(2.0, PUSHED), judged(3.0, PUSHED)] == ["ok", "ok"]
    assert judged(4.0, PUSHED) == "motion_uncommanded"
    assert [judged(4.5), judged(5.5)] == ["motion_uncommanded", "ok"]
    assert judged(6.0, STUCK) == "motion_stuck"
    obeys.unknown()
    assert health.now().reason == "ok"
    assert judged(7.0, STUCK, CORRIDOR) == "ok"
