"""Decodes an RPLIDAR's standard scan stream in bulk; resynchronises after lost or damaged bytes.

A node is 5 bytes: quality << 2 | !S << 1 | S; u16 angle_q6 << 1 | 1; u16 distance_q2 (Slamtec
protocol, "Scan response"). It carries no checksum: only three check bits and the mirror's steady
rotation distinguish a node from garbage.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.angles import in_turn, in_turn_if_near
from gazechair.base.arrays import BoolArray, ByteArray, FloatArray, IntArray

NODE_SIZE = 5
# This many valid nodes in a row with a steadily turning angle prove the alignment. Nodes read one
# to four bytes off can look valid too (before a flat wall some 18 in a row), but don't turn.
_RUN = 24
_MIN_TURN_DEG = 1.0
_BACK_DEG = 1.0
# Neighbouring nodes are about 0.2 degrees apart; the gap after lost bytes is one-sided.
_JUMP_DEG = 8.0
_STEP_DEG = 0.225  # from one node to the next, at 10 turns per second
_MAX_PENDING = 1 << 16


@dataclass(frozen=True)
class Nodes:
    """Nodes in the order they were measured, all arrays of one length.

    `angles_deg`: our frame, 0 = forward, left positive, -180 <= angle < 180.
    `distances_m`: metres from the lidar's centre, 0 = no return.
    `starts`: True on the first node of a turn (the S flag).
    `backlog`: per node, how many nodes follow it in the bytes received so far (0 = newest).
    """

    angles_deg: FloatArray
    distances_m: FloatArray
    starts: BoolArray
    backlog: IntArray

    def __len__(self) -> int:
        return len(self.angles_deg)


class NodeDecoder:
    """Feed it bytes as they arrive; it returns every whole node in them.

    Counters: `fed` bytes read, `resyncs` places where the stream had to be realigned, `dropped`
    bytes discarded there, `implausible` nodes whose angle fits neither neighbour.
    """

    NODE_BYTES = float(NODE_SIZE)

    def __init__(self) -> None:
        self.fed = 0
        self.resyncs = 0
        self.dropped = 0
        self.implausible = 0
        self._pending = b""
        self._searching = True  # the first node is found like any later one

    def wants(self, turn_deg: float) -> int:
        """Bytes still needed for the nodes of the next `turn_deg`, if none is lost."""
        return NODE_SIZE * math.ceil(turn_deg / _STEP_DEG) - len(self._pending)

    def feed(self, data: bytes) -> Nodes:
        """Decode the bytes left over and `data`; up to 24 nodes wait for proof of alignment."""
        self.fed += len(data)
        buf = self._pending + data
        if len(buf) > _MAX_PENDING:
            # Only a reader that slept for a second gets here: data that old is useless.
            self.dropped += len(buf) - _MAX_PENDING
            buf = buf[-_MAX_PENDING:]
            self._searching = True
        pieces: list[ByteArray] = []
        at = 0
        while True:
            if self._searching:
                found = _find_run(buf, at)
                if found < 0:
                    keep = max(at, len(buf) - _RUN * NODE_SIZE)
                    self.dropped += keep - at
                    at = keep
                    break
                if found > at:
                    self.dropped += found - at
                at = found
                self._searching = False
            rows = _rows(buf, at)
            bad = np.flatnonzero(~_valid(rows))
            if not len(bad):
                pieces.append(rows)
                at += len(rows) * NODE_SIZE
                break
            first = int(bad[0])
            pieces.append(rows[:first])
            at += first * NODE_SIZE
            self.resyncs += 1
            self._searching = True
        self._pending = buf[at:]
        return self._nodes(np.concatenate(pieces)) if pieces else self._nodes(_rows(b"", 0))

    def _nodes(self, rows: ByteArray) -> Nodes:
        raw_deg = _raw_deg(rows)
        wide = rows.astype(np.uint16)
        distances_m = (wide[:, 3] | (wide[:, 4] << 8)).astype(np.float64) / 4000.0
        starts = (rows[:, 0] & 1).astype(np.bool_)
        backlog = np.arange(len(rows) - 1, -1, -1, dtype=np.int64)
        good = _plausible(raw_deg)
        self.implausible += len(rows) - int(np.count_nonzero(good))
        return Nodes(
            angles_deg=our_angle(raw_deg)[good],
            distances_m=distances_m[good],
            starts=starts[good],
            backlog=backlog[good],
        )


def our_angle(raw_deg: FloatArray) -> FloatArray:
    """The lidar's clockwise 0..360 as our counter-clockwise -180 <= angle < 180."""
    return in_turn_if_near(180.0 - raw_deg, 360.0) - 180.0


def _rows(buf: bytes, at: int) -> ByteArray:
    count = max(0, len(buf) - at) // NODE_SIZE
    flat = np.frombuffer(buf, dtype=np.uint8, count=count * NODE_SIZE, offset=at if count else 0)
    return flat.reshape(-1, NODE_SIZE)


def _raw_deg(rows: ByteArray) -> FloatArray:
    wide = rows.astype(np.uint16)
    return ((wide[:, 1] >> 1) | (wide[:, 2] << 7)).astype(np.float64) / 64.0


def wrapped_steps(angles_deg: FloatArray) -> FloatArray:
    """Steps from each angle to the next, -180 <= step < 180 degrees; one fewer than angles."""
    return in_turn(angles_deg[1:] - angles_deg[:-1] + 180.0, 360.0) - 180.0


def _valid(rows: ByteArray) -> BoolArray:
    flags = rows[:, 0]
    checked = ((flags ^ (flags >> 1)) & rows[:, 1] & 1).astype(np.bool_)
    # angle_q6 ends at 360 * 64 = 23040 = 0x5A00: the high byte of angle_q6 << 1 | 1 at 0xB4.
    return checked & (rows[:, 2] <= 0xB4)


def _find_run(buf: bytes, at: int) -> int:
    """Byte position of the next proven run of nodes at or after `at`, -1 when there is none."""
    best = -1
    for shift in range(NODE_SIZE):
        rows = _rows(buf, at + shift)
        if len(rows) < _RUN:
            continue
        step = wrapped_steps(_raw_deg(rows))
        # A valid row whose angle continues from the row before it.
        good = np.concatenate(([True], (step > -_BACK_DEG) & (step < _JUMP_DEG))) & _valid(rows)
        runs = np.flatnonzero(np.convolve(good, np.ones(_RUN, dtype=np.int64), "valid") == _RUN)
        turned = np.concatenate(([0.0], np.cumsum(step)))
        runs = runs[turned[runs + _RUN - 1] - turned[runs] > _MIN_TURN_DEG]
        if len(runs):
            start = at + shift + int(runs[0]) * NODE_SIZE
            if best < 0 or start < best:
                best = start
    return best


def _plausible(raw_deg: FloatArray) -> BoolArray:
    """False for a node whose angle jumps away from both neighbours."""
    if len(raw_deg) < 3:
        return np.ones(len(raw_deg), dtype=np.bool_)
    step = np.abs(wrapped_steps(raw_deg)) > _JUMP_DEG
    before = np.concatenate(([True], step))
    after = np.concatenate((step, [True]))
    return ~(before & after)
