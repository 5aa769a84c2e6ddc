"""Frames with a right CRC that are not in the table: counted apart, never taken."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

import wire_reference as reference
from gazelink import crc, frame, messages
from wire_damage import SEED, feed, new_decoder

UNKNOWN_TYPES = [n for n in range(256) if n not in messages.BY_TYPE]
MAX_PAYLOAD = frame.MAX_BODY - crc.CRC_SIZE - messages.HEADER_SIZE


@given(
    st.sampled_from(UNKNOWN_TYPES),
    st.binary(max_size=MAX_PAYLOAD),
    st.sampled_from([SEED, bytes(4)]),
)
def test_a_type_of_a_newer_table_is_unknown(type_id: int, payload: bytes, seed: bytes) -> None:
    """Seeded or frozen: it is somebody's right frame, but not for us."""
    decoder = new_decoder()
    assert feed(decoder, reference.frame(type_id, 0, 0, payload, seed)) == []
    assert (decoder.corrupt, decoder.unknown) == (0, 1)


@pytest.mark.parametrize("message", messages.MESSAGES, ids=lambda message: message.name)
def test_a_known_type_of_another_size_is_unknown(message: messages.Message) -> None:
    """Every size but the table's, from nothing to the longest frame."""
    seed = bytes(4) if message.plain else SEED
    right = message.size - messages.HEADER_SIZE
    for size in set(range(MAX_PAYLOAD + 1)) - {right}:
        decoder = new_decoder()
        wire = reference.frame(message.type_id, 0, 0, b"\x07" * size, seed)
        assert feed(decoder, wire) == [], size
        assert (decoder.corrupt, decoder.unknown) == (0, 1), size


@given(st.binary(max_size=messages.HEADER_SIZE + crc.CRC_SIZE - 1))
def test_less_than_a_header_and_a_crc_is_never_taken(data: bytes) -> None:
    """Whatever its bytes are."""
    decoder = new_decoder()
    assert feed(decoder, reference.cobs(data)) == []


@given(st.integers(0, 3))
def test_counters_wrap_at_sixteen_bits(past: int) -> None:
    """As the statistics frame carries them."""
    decoder = new_decoder()
    decoder.ok = decoder.corrupt = decoder.unknown = 0xFFFF - past
    for _ in range(past + 1):
        feed(decoder, reference.frame(messages.PING.type_id, 0, 0, bytes(4), SEED))
        feed(decoder, b"\x05\x05\0")
        feed(decoder, reference.frame(0xEE, 0, 0, b"", SEED))
    assert (decoder.ok, decoder.corrupt, decoder.unknown) == (0, 0, 0)
