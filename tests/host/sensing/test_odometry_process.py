"""Odometry as a process: its inbox, half turns from a lidar's bytes, and the service around it."""

from __future__ import annotations

import json
import math
import os
import signal
import time
from collections.abc import Iterator
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest

from gazechair.base.health import Health
from gazechair.base.latest_value import Entry
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.half_turns import HalfTurns
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.lidar.stream import ByteStream
from gazechair.sensing.odometry.doubts import CORRIDOR, PUSHED, STUCK
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.obeys import Obeys
from gazechair.sensing.odometry.service import OdometryService
from gazechair.sensing.odometry.shown import shown
from gazelink import codes
from gazesim.s2_frames import capsules
from lidarrig import wait_for

LIDAR = LidarConfig(kind="s2", port="/nowhere", x_m=0.5, mask=((123.0, -123.0),))


def half_turn(at_s: float, lidar: int = 0, second: bool = False) -> HalfTurn:
    """Half a turn in the middle of a room 6 m square."""
    angles = -(np.arange(400) + 0.5) * 0.45 - (180.0 if second else 0.0)
    angles = (angles + 180.0) % 360.0 - 180.0
    c, s = np.abs(np.cos(np.radians(angles))), np.abs(np.sin(np.radians(angles)))
    return HalfTurn(lidar, angles, 3.0 / np.maximum(c, s), at_s - 0.05, at_s)


def test_the_inbox_keeps_what_it_is_given() -> None:
    half = half_turn(12.5)
    found = inbox.unpack(inbox.pack_scan(half))
    assert isinstance(found, HalfTurn)
    assert np.abs(found.angles_deg - half.angles_deg).max() < 0.01
    assert np.abs(found.distances_m - half.distances_m).max() <= 0.0005
    assert (found.lidar, found.first_s, found.last_s) == (0, half.first_s, half.last_s)
    for motion in (Motion(1.0, 359.5, 400, -20), Motion(2.0, None, 0, 0)):
        assert inbox.unpack(inbox.pack_motion(motion)) == motion


@pytest.mark.parametrize("datagram", [b"", b"M", b"Sxx", inbox.pack_scan(half_turn(1.0))[:-3]])
def test_nonsense_in_the_inbox_is_nothing(datagram: bytes) -> None:
    assert inbox.unpack(datagram) is None


def test_an_inbox_that_nobody_reads_loses_and_never_waits() -> None:
    writers, reader = inbox.open_inbox()
    datagram = inbox.pack_scan(half_turn(1.0))
    begin_s = time.monotonic()
    sent = [inbox.send(writers.fileno(), datagram) for _ in range(2000)]
    assert sent[0]
    assert not sent[-1]
    assert time.monotonic() - begin_s < 2.0
    reader.close()
    assert not inbox.send(writers.fileno(), datagram)
    writers.close()


def test_every_half_turn_of_a_lidars_bytes_is_sent_with_its_times() -> None:
    writers, reader = inbox.open_inbox()
    tap = HalfTurns(1, [writers.fileno()])
    stream = ByteStream("dense", codes.SIMULATED, tap.take)
    points = 3200
    for turn in range(4):
        rows = capsules(np.arange(points) / points, np.full(points, 2000.0), after_reset=turn == 0)
        for at in range(0, len(rows), 8):
            stream.feed(rows[at : at + 8].tobytes(), 100.0 + 0.1 * (turn + (at + 8) / len(rows)))
    reader.setblocking(False)
    found = []
    while True:
        try:
            half = inbox.unpack(reader.recv(inbox.LONGEST))
        except BlockingIOError:
            break
        assert isinstance(half, HalfTurn)
        found.append(half)
    assert len(found) in (6, 7)
    for half in found:
        assert half.lidar == 1
        assert half.last_s - half.first_s == pytest.approx(0.05, abs=0.01)
        assert np.all(half.distances_m == 2.0)
        # Direction and time belong together: the mirror turns clockwise, 10 times a second.
        phase = (-half.angles_deg[-1] / 360.0 - (half.last_s - 100.0) * 10.0) % 1.0
        assert min(phase, 1.0 - phase) < 0.05
    writers.close()
    reader.close()


def test_what_is_masked_is_left_out_and_places_are_the_chairs() -> None:
    config = LidarConfig(kind="s2", x_m=-0.4, heading_deg=180.0, mask=((95.0, -95.0),))
    piece = Lidars((LIDAR, config)).piece(half_turn(1.0, lidar=1))
    assert piece is not None
    assert piece.origin_m == (-0.4, 0.0)
    assert piece.per_turn == 798
    assert len(piece.directions_deg) < 400
    assert np.all(np.abs(piece.directions_deg) >= 85.0)
    assert Lidars((LIDAR,)).piece(half_turn(1.0, lidar=1)) is None


@pytest.fixture
def service() -> Iterator[OdometryService]:
    obeys = Obeys(Health("motion"), lambda: None)
    made = OdometryService((LIDAR,), Health("odometry"), obeys)
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
    lidars = replace(LIDAR, name="front"), replace(LIDAR, name="rear")
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
