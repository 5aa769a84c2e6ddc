"""Damaged frames are refused, every one, and the stream recovers at the next delimiter."""

from itertools import combinations
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazelink import cobs, frame
from wire_damage import PLAIN, SEED, WIRES, body, feed, found_in, judged, new_decoder, pieces

every_message = pytest.mark.parametrize("name", sorted(WIRES))
any_message = st.sampled_from(sorted(WIRES))
PING = WIRES["ping"]


def flipped(wire: bytes, *bits: int) -> bytes:
    """`wire` with these bits inverted, counted from bit 0 of the first byte."""
    damaged = bytearray(wire)
    for bit in bits:
        damaged[bit >> 3] ^= 1 << (bit & 7)
    return bytes(damaged)


@every_message
def test_every_truncation_is_refused_and_the_next_frame_passes(name: str) -> None:
    """A frame cut short, with its delimiter sent, is no frame."""
    wire = WIRES[name]
    for length in range(len(wire) - 1):
        assert found_in(wire[:length] + b"\0" + PING) == [body("ping")], length


@every_message
def test_every_missing_beginning_is_refused_and_the_next_frame_passes(name: str) -> None:
    """Listening that begins in the middle of a frame finds the next one."""
    wire = WIRES[name]
    for start in range(1, len(wire)):
        assert found_in(wire[start:] + PING) == [body("ping")], start


@every_message
def test_every_single_bit_flip_is_refused(name: str) -> None:
    """Wherever the flip hits: stuffing, header, payload, CRC or delimiter."""
    wire = WIRES[name]
    for bit in range(len(wire) * 8):
        assert found_in(flipped(wire, bit) + b"\0") == [], bit


@pytest.mark.parametrize("name", ["state", "command", "order", "clearance"])
def test_every_double_bit_flip_is_refused(name: str) -> None:
    """All pairs of bits of the frames that decide about motion."""
    wire = WIRES[name]
    decoder = new_decoder()
    for pair in combinations(range(len(wire) * 8), 2):
        assert feed(decoder, flipped(wire, *pair) + b"\0") == [], pair


@given(any_message, st.data())
def test_any_double_bit_flip_is_refused(name: str, data: st.DataObject) -> None:
    """Pairs of bits of the other frames, drawn."""
    bits = st.integers(0, len(WIRES[name]) * 8 - 1)
    pair = data.draw(st.lists(bits, min_size=2, max_size=2, unique=True))
    assert found_in(flipped(WIRES[name], *pair) + b"\0") == []


@given(st.lists(st.tuples(any_message, st.binary(max_size=200)), max_size=8))
def test_garbage_between_frames_costs_no_frame(parts: list[tuple[str, bytes]]) -> None:
    """Garbage that is cut off by a delimiter takes nothing with it."""
    stream = b"".join(garbage + b"\0" + WIRES[name] for name, garbage in parts)
    decoder = new_decoder()
    assert feed(decoder, stream) == [body(name) for name, _ in parts]
    assert judged(decoder) == pieces(stream)


@given(st.lists(any_message, min_size=3, max_size=6), st.data())
def test_lost_bytes_cost_the_hit_frame_and_at_most_one_more(
    names: list[str], data: st.DataObject
) -> None:
    """A hole inside a frame (its delimiter too) costs that frame and at most the next."""
    wires = [WIRES[name] for name in names]
    hit = data.draw(st.integers(0, len(wires) - 1))
    start = data.draw(st.integers(0, len(wires[hit]) - 1))
    end = data.draw(st.integers(start + 1, len(wires[hit])))
    holed = wires[hit][:start] + wires[hit][end:]
    found = found_in(b"".join([*wires[:hit], holed, *wires[hit + 1 :]]))
    before = [body(name) for name in names[:hit]]
    after = [body(name) for name in names[hit + 1 :]]
    # A hole that swallows the frame whole leaves its neighbours alone.
    assert found in (before + after, before + after[1:])
    if end < len(wires[hit]):
        assert found == before + after


@given(st.binary(max_size=300))
def test_anything_at_all_is_judged_and_never_raises(stream: bytes) -> None:
    """Each non-empty piece up to a delimiter counts once: as good, corrupt or unknown."""
    decoder = new_decoder()
    found = feed(decoder, stream)
    assert decoder.ok == len(found)
    assert judged(decoder) == pieces(stream)


@given(any_message, st.integers(0, 40))
def test_runs_of_zeros_are_no_frames_and_no_errors(name: str, run: int) -> None:
    """A cable full of zeros is quiet."""
    decoder = new_decoder()
    assert feed(decoder, bytes(run) + WIRES[name] + bytes(run)) == [body(name)]
    assert judged(decoder) == 1


@given(st.integers(frame.MAX_WIRE - 1, 2000), st.integers(1, 255))
def test_oversized_frames_are_refused_and_the_next_passes(size: int, byte: int) -> None:
    """Too long by one or by thousands: counted once, nothing beyond the buffer is touched."""
    decoder = new_decoder()
    assert feed(decoder, bytes([byte]) * size + b"\0" + PING) == [body("ping")]
    assert decoder.corrupt == 1
    assert len(decoder.buf) == frame.MAX_BODY


def test_the_longest_body_passes_the_unstuffing_and_one_more_byte_does_not() -> None:
    """The limit itself: 62 bytes of body are taken up whole."""
    for n, kept in ((frame.MAX_BODY, True), (frame.MAX_BODY + 1, False)):
        decoder = new_decoder()
        out = bytearray(n + 2)
        for byte in out[: cobs.encode(b"\1" * n, n, out) - 1]:
            decoder.feed(byte)
        assert (decoder._n == n and not decoder._bad) == kept


@every_message
@given(seed=st.binary(min_size=4, max_size=4).filter(lambda seed: seed != SEED))
def test_another_session_s_frames_are_refused_but_plain_ones_pass(name: str, seed: bytes) -> None:
    """Another seed is another version, another host or another life of the board."""
    decoder = new_decoder(seed)
    expected = [body(name)] if name in PLAIN else []
    assert feed(decoder, WIRES[name]) == expected
    assert (decoder.ok, decoder.corrupt) == (len(expected), 1 - len(expected))


@every_message
def test_before_any_session_only_plain_frames_pass(name: str) -> None:
    """No seed: nothing can move, HELLO, NONCE, FAULT and MAINTENANCE are heard."""
    assert found_in(WIRES[name], seed=None) == ([body(name)] if name in PLAIN else [])


def seed_of(session: int, boot: int, nonce: bytes, epoch: int) -> bytes:
    keys = frame.Session()
    keys.begin(session, boot, nonce, epoch, 0)
    return bytes(keys.seed(0))


ids = st.tuples(st.integers(1, 0xFFFF), st.integers(0, 0xFFFF))
nonces = st.binary(min_size=4, max_size=4)
epochs = st.integers(0, 0x3FFFFFFF)


@given(ids, ids, nonces, epochs)
def test_session_and_boot_both_tell_frames_apart(
    one: Any, other: Any, nonce: bytes, e: int
) -> None:
    """CRC-32 keeps 4-byte inputs apart: two pairs of ids never share a seed."""
    assert (seed_of(*one, nonce, e) == seed_of(*other, nonce, e)) == (one == other)


@given(ids, nonces, nonces, epochs, epochs)
def test_nonce_and_round_tell_frames_apart(
    pair: Any, n1: bytes, n2: bytes, e1: int, e2: int
) -> None:
    """Nor do two nonces, or two rounds of the stamp in one session."""
    assert (seed_of(*pair, n1, e1) == seed_of(*pair, n2, e1)) == (n1 == n2)
    assert (seed_of(*pair, n1, e1) == seed_of(*pair, n1, e2)) == (e1 == e2)
