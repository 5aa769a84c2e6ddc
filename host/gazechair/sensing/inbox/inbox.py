"""Datagrams of scans and of board reports, on one socket for each process that reads them.

Odometry, mapping, assist and auto motions do; mapping and auto motions get estimates, too.

The lidars' child and the daemon write without ever waiting: what does not fit is lost. The socket
outlives the child at either end.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import socket
import struct
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from gazechair.base import json_text
from gazechair.base.arrays import FloatArray
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.estimate import Estimate

LONGEST = 1 << 16
_SCAN = struct.Struct("<cBHdd")  # kind, lidar, measurements, times of the first and the last
_MOTION = struct.Struct("<cddhh")
_BUFFER = 1 << 18
_MOST = 256  # datagrams at a time
_ANGLE = 64.0  # units per degree


@dataclass(frozen=True)
class HalfTurn:
    """Consecutive measurements of one lidar, in its own frame; see lidar.scan.Scan."""

    lidar: int
    """Its index in the configuration."""
    angles_deg: FloatArray
    distances_m: FloatArray
    first_s: float
    last_s: float


def open_inbox() -> tuple[socket.socket, socket.socket]:
    """A socket pair: (for the writers, for the reader)."""
    writers, reader = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    for end in (writers, reader):
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
    writers.setblocking(False)
    return writers, reader


def send(fd: int, datagram: bytes) -> bool:
    """Write it; False when it is lost."""
    try:
        os.write(fd, datagram)
    except OSError:
        return False
    return True


def waiting(reader: socket.socket) -> Iterator[bytes]:
    """The datagrams that have come, at most _MOST. Never waits."""
    with contextlib.suppress(BlockingIOError):
        for _ in range(_MOST):
            yield reader.recv(LONGEST, socket.MSG_DONTWAIT)


def pack_scan(half: HalfTurn) -> bytes:
    """As one datagram."""
    head = _SCAN.pack(b"S", half.lidar, len(half.angles_deg), half.first_s, half.last_s)
    angles = np.rint(half.angles_deg * _ANGLE).astype("<i2")
    mm = np.rint(half.distances_m * 1000.0)
    np.minimum(np.maximum(mm, 0.0, out=mm), 65535.0, out=mm)  # np.clip takes several times as long
    return head + angles.tobytes() + mm.astype("<u2").tobytes()


def pack_motion(motion: Motion) -> bytes:
    """As one datagram. Its outputs must be known."""
    heading = math.nan if motion.heading_deg is None else motion.heading_deg
    outputs = motion.linear_permille or 0, motion.turn_permille or 0
    return _MOTION.pack(b"M", motion.time_s, heading, *outputs)


def pack_estimate(estimate: Estimate) -> bytes:
    """As one datagram."""
    return b"E" + json.dumps(asdict(estimate)).encode()


def unpack(datagram: bytes) -> HalfTurn | Motion | Estimate | None:
    """The content of a datagram; None: it is malformed."""
    try:
        if datagram[:1] == b"E":
            fields = json_text.parse(datagram[1:])
            return Estimate(**{**fields, "doubts": tuple(fields["doubts"])})
        if datagram[:1] == b"M":
            _, time_s, heading, linear, turn = _MOTION.unpack(datagram)
            return Motion(time_s, None if math.isnan(heading) else heading, linear, turn)
        _, lidar, count, first_s, last_s = _SCAN.unpack_from(datagram)
        angles = np.frombuffer(datagram, "<i2", count, _SCAN.size) / _ANGLE
        metres = np.frombuffer(datagram, "<u2", count, _SCAN.size + 2 * count) / 1000.0
    except (struct.error, ValueError, TypeError, KeyError):
        return None
    return HalfTurn(lidar, angles, metres, first_s, last_s)
