"""Odometry as a process: its inbox, half turns from a lidar's bytes, and the service around it."""

from __future__ import annotations

import math
import os
import signal
import time
from collections.abc import Iterator

import numpy as np
import pytest

from gazechair.config.configuration import LidarConfig
from gazechair.sensing.lidar.stream import ByteStream
from gazechair.sensing.odometry import inbox
from gazechair.sensing.odometry.child import Lidars
from gazechair.sensing.odometry.half_turns import HalfTurns
from gazechair.sensing.odometry.inbox import HalfTurn
from gazechair.sensing.odometry.odometry import Motion
from gazechair.sensing.odometry.service import OdometryService
from gazelink import codes
from gazesim.s2_frames import capsules
from lidarrig import wait_for

LIDAR = LidarConfig(kind="s2", port="/nowhere", x_m=0.5, mask=((123.0, -123.0),))


def half_turn(at_s: float, lidar: int = 0, second: bool = False) -> HalfTurn:
    """In the middle of a room 6 m square."""
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
    tap = HalfTurns(1, writers.fileno())
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
    made = OdometryService((LIDAR,))
    made.start()
    yield made
    made.stop()


def feed(service: OdometryService, seconds: float) -> None:
    """As from a chair that stands."""
    end_s, second = time.monotonic() + seconds, False
    while time.monotonic() < end_s:
        now_s = time.monotonic()
        service.motion(Motion(now_s, 90.0, 0, 0))
        inbox.send(service.inbox_fd, inbox.pack_scan(half_turn(now_s, second=second)))
        second = not second
        time.sleep(0.05)


def test_the_process_estimates_and_comes_back_when_it_is_killed(service: OdometryService) -> None:
    def estimated() -> bool:
        feed(service, 0.2)
        return service.latest.get() is not None

    wait_for(estimated, lambda: str(service.status))
    entry = service.latest.entry()
    assert entry is not None
    assert math.hypot(entry.value.x_m, entry.value.y_m) < 0.01
    assert entry.born_s == entry.value.time_s
    assert abs(entry.value.time_s - time.monotonic()) < 1.0
    assert service.pid is not None
    os.kill(service.pid, signal.SIGKILL)
    wait_for(lambda: service.latest.get() is None, lambda: str(service.status))
    wait_for(estimated, lambda: str(service.status))
    assert service.restarts >= 1
