"""A scan for the log, sent from child to daemon: the nearest return in each half degree."""

from __future__ import annotations

import struct

import numpy as np

from gazechair.sensing.lidar.scan import Scan

BEAMS = 720
PERIOD_S = 0.5

_NONE = 65535
_FARTHEST = _NONE - 1

_HEAD = struct.Struct("<d20s")


def pack(name: str, scan: Scan) -> bytes:
    """The scan of the lidar `name`: beam 0 begins at -180 degrees of the lidar's own frame;
    0 mm: no return."""
    at = ((scan.angles_deg + 180.0) * (BEAMS / 360.0)).astype(np.int64) % BEAMS
    mm = np.clip(scan.distances_m * 1000.0, 0, _FARTHEST).astype("<u2")
    beams = np.full(BEAMS, _NONE, "<u2")
    returned = mm > 0
    np.minimum.at(beams, at[returned], mm[returned])
    beams[beams == _NONE] = 0
    return _HEAD.pack(scan.acquired_s, name.encode()[:20]) + beams.tobytes()


def unpack(payload: bytes) -> tuple[str, float, bytes]:
    """Name, monotonic seconds of its oldest measurement, and the beams in mm, little-endian."""
    acquired_s, name = _HEAD.unpack_from(payload)
    return name.rstrip(b"\0").decode("utf-8", "replace"), acquired_s, payload[_HEAD.size :]
