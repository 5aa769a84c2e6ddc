"""The wire against its plain description: every message, any values, byte for byte."""

import struct

from hypothesis import given
from hypothesis import strategies as st

import wire_reference as reference
from gazelink import cobs, frame, messages
from wire_vectors import FRAME_SEED, FRAMES, OneSeed

RANGES = {"B": (0, 0xFF), "H": (0, 0xFFFF), "h": (-0x8000, 0x7FFF), "I": (0, 0xFFFFFFFF)}
SEED = bytes.fromhex(FRAME_SEED)


def values_of(message: messages.Message) -> st.SearchStrategy[tuple[int | bytes, ...]]:
    """Any values the fields of `message` can hold, in table order."""
    parts: list[st.SearchStrategy[int | bytes]] = []
    for field in message.fields.split():
        letters = field.split(":")[1]
        if letters.endswith("s"):
            n = int(letters[:-1])
            parts.append(st.binary(min_size=n, max_size=n))
        else:
            parts.append(st.integers(*RANGES[letters]))
    return st.tuples(*parts)


any_message = st.sampled_from(messages.MESSAGES).flatmap(
    lambda message: st.tuples(st.just(message), values_of(message))
)


@given(any_message, st.integers(0, 0xFF), st.integers(0, 0xFFFF), st.binary(min_size=4, max_size=4))
def test_encodes_as_described_and_decodes_to_the_same_values(made, seq, stamp_ms, seed) -> None:
    """Round trip through both implementations."""
    message, values = made
    encoder = frame.Encoder()
    encoder.session = OneSeed(seed)
    encoder._seq = (seq - 1) & 0xFF
    message.pack(encoder.body, values)
    wire = bytes(encoder.wire[: encoder.finish(message, stamp_ms)])

    payload = struct.pack(message.format, *values)
    crc_seed = bytes(4) if message.plain else seed
    assert wire == reference.frame(message.type_id, seq, stamp_ms, payload, crc_seed)

    decoder = frame.Decoder()
    decoder.session = OneSeed(seed)
    assert [decoder.feed(byte) for byte in wire] == [False] * (len(wire) - 1) + [True]
    assert decoder.length == message.size
    assert decoder.buf[messages.TYPE_AT] == message.type_id
    assert decoder.buf[messages.SEQ_AT] == seq
    assert frame.u16(decoder.buf, messages.STAMP_AT) == stamp_ms
    assert message.unpack(decoder.buf) == dict(zip(message.names, values, strict=True))


@given(st.binary(max_size=frame.MAX_BODY))
def test_cobs_is_as_described(data: bytes) -> None:
    """Any body up to the limit: same bytes, two more than the body, no zero but the last."""
    out = bytearray(frame.MAX_WIRE)
    n = cobs.encode(data, len(data), out)
    assert bytes(out[:n]) == reference.cobs(data)
    assert n == len(data) + 2
    assert 0 not in out[: n - 1]


@given(
    st.integers(0, 0xFFFF),
    st.integers(0, 0xFFFF),
    st.binary(min_size=4, max_size=4),
    st.integers(0, 0x3FFFFFFE),
    st.integers(0, 0xFFFF),
    st.lists(st.integers(0, 0x7FFF), max_size=20),
    st.integers(-0x8000, 0x7FFF),
)
def test_session_seed_is_as_described(
    session: int, boot: int, nonce: bytes, epoch: int, start_ms: int, steps: list[int], off_ms: int
) -> None:
    """The seed binds table, session, boot, nonce, and the round of the clock a stamp belongs to."""
    keys = frame.Session()
    assert keys.seed(start_ms) is None
    keys.begin(session, boot, nonce, epoch, start_ms)
    for step in steps:
        keys.advance((keys.clock_ms + step) & 0xFFFF)
    clock_ms = (epoch << 16) + start_ms + sum(steps)
    assert (keys.epoch, keys.clock_ms) == (clock_ms >> 16 & 0x3FFFFFFF, clock_ms & 0xFFFF)
    meant_ms = clock_ms + off_ms
    expected = reference.seed(
        messages.schema_text(), session, boot, nonce, meant_ms >> 16 & 0x3FFFFFFF
    )
    assert bytes(keys.seed(meant_ms & 0xFFFF)) == expected
    keys.end()
    assert keys.seed(meant_ms & 0xFFFF) is None


def test_known_frames_are_the_reference_s() -> None:
    """The known answers come from the description, not from the code they check."""
    rows = {message.name: message for message in messages.MESSAGES}
    for name, seq, stamp_ms, values, wire in FRAMES:
        message = rows[name]
        seed = bytes(4) if message.plain else SEED
        payload = struct.pack(message.format, *values)
        assert reference.frame(message.type_id, seq, stamp_ms, payload, seed).hex() == wire


def test_any_change_of_a_row_changes_the_hash() -> None:
    """Type, name, direction, field, format and frozen are all in the text the hash is made of."""
    rows = [
        messages.Message(1, "a", "up", "x:B"),
        messages.Message(2, "a", "up", "x:B"),
        messages.Message(1, "b", "up", "x:B"),
        messages.Message(1, "a", "down", "x:B"),
        messages.Message(1, "a", "up", "y:B"),
        messages.Message(1, "a", "up", "x:b"),
        messages.Message(1, "a", "up", "x:B", True),
    ]
    assert len({messages.schema_text((row,)) for row in rows}) == len(rows)
