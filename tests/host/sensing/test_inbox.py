"""The inbox of processes that use lidars: messages, half turns from a lidar's bytes, places."""

from __future__ import annotations

import time

import numpy as np
import pytest

from gazechair.board.state import BoardState
from gazechair.config.settings import LidarConfig
from gazechair.sensing.inbox import inbox
from gazechair.sensing.inbox.feed import HEADING_LATE_S, Feed
from gazechair.sensing.inbox.half_turns import HalfTurns
from gazechair.sensing.inbox.inbox import HalfTurn
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Lidars
from gazechair.sensing.lidar.stream import ByteStream
from gazelink import codes
from gazesim.s2_frames import capsules

FRONT = LidarConfig(kind="s2", port="/nowhere", x_m=0.5, mask=((123.0, -123.0),))


def half_turn(at_s: float, lidar: int = 0, second: bool = False) -> HalfTurn:
    """Half a turn in the middle of a room 6 m square."""
    angles = -(np.arange(400) + 0.5) * 0.45 - (180.0 if second else 0.0)
    angles = (angles + 180.0) % 360.0 - 180.0
    c, s = np.abs(np.cos(np.radians(angles))), np.abs(np.sin(np.radians(angles)))
    return HalfTurn(lidar, angles, 3.0 / np.maximum(c, s), at_s - 0.05, at_s)


def motion_of(state: BoardState) -> Motion:
    """What an inbox gets of a state of the board."""
    writers, reader = inbox.open_inbox()
    with writers, reader:
        Feed([writers.fileno()]).board(state)
        motion = inbox.unpack(reader.recv(inbox.LONGEST))
    assert isinstance(motion, Motion)
    return motion


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
    piece = Lidars((FRONT, config)).piece(half_turn(1.0, lidar=1))
    assert piece is not None
    assert piece.origin_m == (-0.4, 0.0)
    assert piece.per_turn == 798
    assert len(piece.directions_deg) < 400
    assert np.all(np.abs(piece.directions_deg) >= 85.0)
    assert Lidars((FRONT,)).piece(half_turn(1.0, lidar=1)) is None


def test_the_board_is_heard_of_headings_that_are_late() -> None:
    state = BoardState(codes.ARMED, 0, 0, 0, 0, 0, 90.0, 0, 300, 0, 0, 0, 2.0)
    assert motion_of(state).time_s == pytest.approx(2.0 - HEADING_LATE_S)
