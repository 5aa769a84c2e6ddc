"""An S2's replies as bytes: descriptors, standard nodes, dense capsules (Slamtec's protocol)."""

from __future__ import annotations

import struct

import numpy as np

from gazechair.base.arrays import ByteArray, FloatArray

POINTS_PER_CAPSULE = 40
CAPSULE_SIZE = 84
_QUALITY = 47


def descriptor(length: int, loop: bool, kind: int) -> bytes:
    """What announces a reply of `length` bytes, or a stream of such pieces (`loop`)."""
    return b"\xa5\x5a" + struct.pack("<IB", length | (0x40000000 if loop else 0), kind)


def nodes(turns: FloatArray, distances: FloatArray) -> ByteArray:
    """Standard nodes (n, 5) at `turns`, shares 0..1 of a turn; distances in mm, 0 = none."""
    rows = np.empty((len(turns), 5), dtype=np.uint8)
    first = (turns == 0.0).astype(np.uint8)  # a new turn begins
    quality = np.where(distances > 0, _QUALITY, 0).astype(np.uint8)
    rows[:, 0] = quality << 2 | (1 - first) << 1 | first
    angle = (turns * 360.0 * 64.0).astype(np.uint16) << 1 | 1
    rows[:, 1:3] = angle.astype("<u2").view(np.uint8).reshape(-1, 2)
    fits = distances < 16384.0  # the range of 16 bits of quarter millimetres
    distance = np.where(fits, distances * 4.0, 0.0).astype("<u2")
    rows[:, 3:5] = distance.view(np.uint8).reshape(-1, 2)
    return rows


def capsules(turns: FloatArray, distances: FloatArray, after_reset: bool) -> ByteArray:
    """Dense capsules (n, 84) of 40 points each; `after_reset` marks the first one."""
    count = len(turns) // POINTS_PER_CAPSULE
    rows = np.empty((count, CAPSULE_SIZE), dtype=np.uint8)
    start = (turns[::POINTS_PER_CAPSULE] * 360.0 * 64.0).astype("<u2")
    if after_reset:
        start[0] |= 0x8000  # the encoder was reset; not set at each turn
    rows[:, 2:4] = start.view(np.uint8).reshape(-1, 2)
    points = np.minimum(np.maximum(distances, 0.0), 65535.0).astype("<u2").view(np.uint8)
    rows[:, 4:] = points.reshape(count, 2 * POINTS_PER_CAPSULE)
    checksum = np.bitwise_xor.reduce(rows[:, 2:], axis=1)
    rows[:, 0] = 0xA0 | (checksum & 0x0F)
    rows[:, 1] = 0x50 | (checksum >> 4)
    return rows


def damaged(
    octets: ByteArray, random: np.random.Generator, corrupt: float, drop: float
) -> ByteArray:
    """`octets` with a share of them made wrong and a share of them left out."""
    octets = octets.copy()
    hit = random.random(len(octets)) < corrupt
    octets[hit] ^= random.integers(1, 256, int(hit.sum())).astype(np.uint8)
    kept: ByteArray = octets[random.random(len(octets)) >= drop]
    return kept
