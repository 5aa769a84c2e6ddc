"""A stream knows how many bytes are missing to complete the quarter turn of its lidar."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.sensing.lidar.dense import CAPSULE_SIZE, POINTS
from gazechair.sensing.lidar.stream import ByteStream
from gazelink import codes
from gazesim.s2_frames import capsules

A_TURN = 80  # capsules


def turns(count: int) -> bytes:
    beams = np.arange(count * A_TURN * POINTS)
    ranges_mm = 2000.0 + np.random.default_rng(1).normal(0.0, 6.0, len(beams))
    return capsules(beams / (A_TURN * POINTS) % 1.0, ranges_mm, after_reset=True).tobytes()


@pytest.mark.parametrize("more", [0, 1, 50, 83])
def test_the_bytes_it_wants_complete_the_quarter_turn_and_no_fewer(more: int) -> None:
    data = turns(5)
    stream = ByteStream("dense", codes.SIMULATED)
    at = (3 * A_TURN // 2 + 4) * CAPSULE_SIZE + more
    stream.feed(data[:at], 1.0)
    for _ in range(8):
        wanted, quarters = stream.wants, stream.quarters
        assert CAPSULE_SIZE <= wanted <= (A_TURN // 4 + 2) * CAPSULE_SIZE
        assert not stream.feed(data[at : at + wanted - 1], 1.0)
        assert stream.wants == CAPSULE_SIZE  # never less: a look at each byte would cost more
        assert stream.feed(data[at + wanted - 1 : at + wanted], 1.0)
        assert stream.quarters == quarters + 1
        at += wanted


def test_before_the_mirrors_speed_is_known_it_wants_little() -> None:
    stream = ByteStream("dense", codes.SIMULATED)
    assert stream.wants <= 2 * CAPSULE_SIZE
    stream.feed(b"\x00" * 1000, 1.0)
    assert stream.wants <= 2 * CAPSULE_SIZE
