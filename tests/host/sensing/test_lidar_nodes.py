"""The stream decoder: every node is decoded, and every loss or damage costs only a few nodes."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.sensing.lidar.nodes import NodeDecoder, Nodes, our_angle

PER_TURN = 1600


def stream(count: int = PER_TURN, first: int = 0, distance_mm: int | None = None) -> bytes:
    """Nodes as the S2 sends them: the mirror turns clockwise, 0.225 degrees a node."""
    out = bytearray()
    for index in range(first, first + count):
        start = index % PER_TURN == 0
        angle_q6 = int(index % PER_TURN * 360 * 64 / PER_TURN)
        mm = distance_mm if distance_mm is not None else 1000 + 7 * (index % 700)
        out += struct.pack("<BHH", 47 << 2 | (1 if start else 2), angle_q6 << 1 | 1, mm * 4)
    return bytes(out)


def decode(data: bytes, sizes: int = 1 << 20) -> tuple[list[Nodes], NodeDecoder]:
    decoder = NodeDecoder()
    return [decoder.feed(data[i : i + sizes]) for i in range(0, len(data), sizes)], decoder


def total(parts: list[Nodes]) -> int:
    return sum(len(part) for part in parts)


def test_a_clean_stream_comes_out_whole() -> None:
    (nodes,), decoder = decode(stream())
    assert len(nodes) == PER_TURN
    assert nodes.starts.tolist() == [True] + [False] * (PER_TURN - 1)
    assert nodes.distances_m[3] == pytest.approx(1.021)
    assert nodes.backlog[0] == PER_TURN - 1
    assert nodes.backlog[-1] == 0
    assert (decoder.resyncs, decoder.dropped, decoder.implausible) == (0, 0, 0)


@pytest.mark.parametrize(
    ("raw_deg", "ours_deg"), [(0, 0), (10, -10), (90, -90), (180, -180), (270, 90), (350, 10)]
)
def test_angles_are_ours_forward_zero_left_positive(raw_deg: float, ours_deg: float) -> None:
    assert our_angle(np.array([float(raw_deg)]))[0] == ours_deg


@settings(deadline=None)
@given(st.integers(1, 700))
def test_the_size_of_the_pieces_does_not_matter(size: int) -> None:
    parts, decoder = decode(stream(400), size)
    joined = np.concatenate([part.angles_deg for part in parts])
    whole = decode(stream(400))[0][0]
    assert np.array_equal(joined, whole.angles_deg)
    assert decoder.resyncs == 0


def test_what_an_earlier_reader_left_is_skipped() -> None:
    (nodes,), decoder = decode(stream(300, first=11)[3:])
    assert len(nodes) >= 299
    assert decoder.dropped <= 10


@pytest.mark.parametrize("distance_mm", [None, 2032, 16383])
def test_every_single_lost_byte_costs_a_few_nodes(distance_mm: int | None) -> None:
    good = stream(200, distance_mm=distance_mm)
    for lost in range(len(good)):
        (nodes,), _ = decode(good[:lost] + good[lost + 1 :])
        assert len(nodes) >= 200 - 30
        _plausible(nodes, distance_mm)


@pytest.mark.parametrize("distance_mm", [None, 2032])
@pytest.mark.parametrize("flip", [0x01, 0x03, 0x80, 0xFF])
def test_every_single_damaged_byte_costs_a_few_nodes(distance_mm: int | None, flip: int) -> None:
    good = stream(200, distance_mm=distance_mm)
    for at in range(len(good)):
        data = bytearray(good)
        data[at] ^= flip
        (nodes,), _ = decode(bytes(data))
        assert len(nodes) >= 200 - 30


def _plausible(nodes: Nodes, distance_mm: int | None) -> None:
    """Garbage nodes next to the damage are few: angles and distances are the stream's otherwise."""
    if distance_mm is not None:
        wrong = np.abs(nodes.distances_m * 1000 - distance_mm) > 1
        assert np.count_nonzero(wrong) <= 4


@settings(deadline=None)
@given(st.binary(max_size=200), st.integers(0, 999))
def test_garbage_in_the_middle_is_survived(garbage: bytes, cut: int) -> None:
    good = stream(400)
    (nodes,), _ = decode(good[:cut] + garbage + good[cut:])
    assert len(nodes) >= 400 - 60


@settings(max_examples=300, deadline=None)
@given(st.lists(st.binary(max_size=300), max_size=8))
def test_any_bytes_are_taken_without_an_error(pieces: list[bytes]) -> None:
    decoder = NodeDecoder()
    for piece in pieces:
        nodes = decoder.feed(piece)
        assert np.all((nodes.angles_deg >= -180) & (nodes.angles_deg < 180))
        assert np.all((nodes.distances_m >= 0) & (nodes.distances_m < 16.4))


@settings(deadline=None)
@given(st.binary(min_size=1000, max_size=3000))
def test_noise_yields_no_nodes(noise: bytes) -> None:
    # Bytes that are all alike turn nowhere; random ones are no run of 24 valid nodes.
    assert total(decode(noise)[0]) == 0


def test_a_flat_stretch_read_off_its_alignment_is_not_believed() -> None:
    # Distance 0x0141 * k and quality 15 make rows that pass the check bits two bytes off.
    node = struct.pack("<BHH", 15 << 2 | 2, 1, 0x0141)
    assert total(decode(node * 400)[0]) == 0


def test_a_flood_of_old_bytes_is_cut_to_what_is_recent() -> None:
    decoder = NodeDecoder()
    nodes = decoder.feed(stream(30_000))
    assert 13_000 < len(nodes) < 13_200
    assert decoder.dropped > 80_000


def test_a_node_whose_angle_fits_no_neighbour_is_left_out() -> None:
    data = bytearray(stream(100))
    data[50 * 5 + 2] ^= 0x40
    (nodes,), decoder = decode(bytes(data))
    assert len(nodes) == 99
    assert decoder.implausible == 1
