"""Measures what damaged bytes do to the dense scan: accepted false capsules and their effect."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from gazechair.base.angles import half_turn_deg
from gazechair.base.arrays import BoolArray, ByteArray, FloatArray, IntArray
from gazechair.sensing.lidar.dense import CAPSULE_SIZE, POINT_PERIOD_S, POINTS, CapsuleDecoder
from gazechair.sensing.lidar.scan import BINS, Scan
from gazechair.sensing.lidar.stream import ByteStream
from gazelink import codes
from gazemeasure.lidar.emulator import room
from gazesim.lidar_noise import MISSING, NOISE_M
from gazesim.s2_frames import capsules, damaged

PER_TURN = 3200
_BATCH = 20_000  # capsules
_WAITING = 16
PIECE_BYTES = 4 * CAPSULE_SIZE  # 5 ms
_FURTHER_M = 8.0
_EXTENDED_M = 0.5
_AT_MIRROR_DEG = 30.0  # near the mirror: some capsules may be in transit or lost


def _turn_of(count: int, first: int = 0) -> FloatArray:
    """Mirror positions, 0..1 of a turn, of `count` capsules from number `first` on."""
    points = np.arange(first * POINTS, (first + count) * POINTS)
    return np.asarray((points % PER_TURN) / PER_TURN)


def clean(count: int, random: np.random.Generator, first: int = 0) -> ByteArray:
    """Capsules of the emulator's room, ranges with noise and misses, as rows."""
    turns = _turn_of(count, first)
    metres = room(-2.0 * np.pi * turns) + random.standard_normal(len(turns)) * NOISE_M
    metres[random.random(len(turns)) < MISSING] = 0.0
    return capsules(turns, metres * 1000.0, after_reset=first == 0)


def decode_share(seconds: float) -> tuple[float, float]:
    """CPU time over stream time of decoding in 5 ms pieces: the decoder alone; and with scans."""
    random = np.random.default_rng(1)
    data = clean(round(seconds / (POINTS * POINT_PERIOD_S)), random).tobytes()
    decoder = CapsuleDecoder()
    start_s = time.process_time()
    for at in range(0, len(data), PIECE_BYTES):
        decoder.feed(data[at : at + PIECE_BYTES])
    alone_s = time.process_time() - start_s
    stream = ByteStream("dense", codes.SIMULATED)
    start_s = time.process_time()
    for at in range(0, len(data), PIECE_BYTES):
        if stream.feed(data[at : at + PIECE_BYTES], at / CAPSULE_SIZE * POINTS * POINT_PERIOD_S):
            stream.scan()
    return alone_s / seconds, (time.process_time() - start_s) / seconds


@dataclass
class Count:
    """Of one kind of damage: capsules sent, of them hit, decoded, and decoded wrong."""

    sent: int = 0
    hit: int = 0
    decoded: int = 0
    undetected: int = 0
    reported_share: float = 0.0


def count_undetected(capsule_count: int, corrupt: float, drop: float, seed: int) -> Count:
    """Damage a stream of `capsule_count` capsules; what is decoded and was not sent is wrong."""
    random = np.random.default_rng(seed)
    count = Count()
    decoder = CapsuleDecoder()
    waiting: set[bytes] = set()  # the decoder may still hold the last ones of a batch
    for batch in range(0, capsule_count, _BATCH):
        rows = clean(_BATCH, random, batch)
        octets = damaged(rows.reshape(-1), random, corrupt, drop).tobytes()
        sent = waiting | {row.tobytes() for row in rows[:, 4:]}
        waiting = {row.tobytes() for row in rows[-_WAITING:, 4:]}
        for at in range(0, len(octets), 10 * PIECE_BYTES):
            nodes = decoder.feed(octets[at : at + 10 * PIECE_BYTES])
            seen = np.round(nodes.distances_m * 1000.0).astype("<u2").reshape(-1, POINTS)
            count.decoded += len(seen)
            count.undetected += sum(row.tobytes() not in sent for row in seen)
        count.sent += _BATCH
    count.hit = round(count.sent * (1.0 - (1.0 - corrupt - drop) ** CAPSULE_SIZE))
    count.reported_share = decoder.dropped / decoder.fed
    return count


def longest_extension(turns: int, seed: int) -> tuple[int, int]:
    """The most passes of the mirror during which wrong points make a degree look free; 1 is the
    pass that measured them. And the number of wrong capsules.

    One capsule in 100 is wrong as a whole, 8 m too far with a good checksum, as if all checks had
    failed, but never at the same place twice in a row; and one byte in 1000 is lost. A degree looks
    free while all its points in a scan are at least 0.5 m beyond the true surface.
    """
    random = np.random.default_rng(seed)
    stream = ByteStream("dense", codes.SIMULATED)
    per_turn = PER_TURN // POINTS
    first_pass = np.full(BINS, -1)
    longest, wrong = 0, 0
    last = np.zeros(per_turn, dtype=np.bool_)
    truth = _nearest_truth()
    for turn in range(turns):
        rows = clean(per_turn, random, turn * per_turn)
        near_last = last | np.roll(last, 1) | np.roll(last, -1)
        last = bad = (random.random(per_turn) < 0.01) & ~near_last
        wrong += int(bad.sum())
        rows = _shifted(rows, bad)
        octets = damaged(rows.reshape(-1), random, 0.0, 0.001).tobytes()
        for at in range(0, len(octets), PIECE_BYTES):
            now_s = (turn + at / len(octets)) * 0.1
            if stream.feed(octets[at : at + PIECE_BYTES], now_s) and (scan := stream.scan()):
                passes, settled = _passes(stream.quarters)
                free = _nearest(scan) > truth + _EXTENDED_M
                begun = settled & free & (first_pass < 0)
                first_pass[begun] = passes[begun]
                first_pass[settled & ~free] = -1
                held = settled & (first_pass >= 0)
                if held.any():
                    longest = max(longest, int((passes - first_pass)[held].max()) + 1)
    return longest, wrong


def _passes(quarters: int) -> tuple[IntArray, BoolArray]:
    """Per degree: how often the mirror has passed it; and True if the mirror is not near it."""
    raw_deg = -(np.arange(BINS, dtype=np.float64) - BINS / 2 + 0.5) % 360.0
    behind_deg = 90.0 * (quarters % 4) - raw_deg
    passes = quarters // 4 + (behind_deg > 0.0)
    return passes.astype(np.int64), np.abs(half_turn_deg(behind_deg)) > _AT_MIRROR_DEG


def _shifted(rows: ByteArray, chosen: BoolArray) -> ByteArray:
    distances = np.ascontiguousarray(rows[:, 4:]).view("<u2").astype(np.float64)
    distances[chosen] += _FURTHER_M * 1000.0
    starts = np.ascontiguousarray(rows[:, 2:4]).view("<u2").reshape(-1)
    turns = (starts & 0x7FFF) / 64.0 / 360.0
    return capsules(np.repeat(turns, POINTS), distances.reshape(-1), after_reset=False)


def _nearest_truth() -> FloatArray:
    angles_deg = np.arange(-180.0, 180.0, 0.05)
    metres = room(np.radians(angles_deg) % (2.0 * np.pi))
    return np.asarray(metres.reshape(BINS, -1).max(axis=1))


def _nearest(scan: Scan) -> FloatArray:
    """Per degree, -inf where the scan has no return: that is blind, not free."""
    found = np.full(BINS, np.inf)
    returned = scan.distances_m > 0.0
    bins = np.minimum((scan.angles_deg[returned] + 180.0).astype(np.int64), BINS - 1)
    np.minimum.at(found, bins, scan.distances_m[returned])
    found[np.isinf(found)] = -np.inf
    return found
