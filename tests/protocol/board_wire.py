# The wire on both Pythons: known answers, and decoding and encoding without any allocation.

from boardtest import no_allocation, raises
from gazelink import crc, frame, messages
from wire_vectors import CRC_CHECK, CRCS, FRAME_SEED, FRAMES, SCHEMA_HASH, SEEDS, OneSeed

SEED = bytes.fromhex(FRAME_SEED)
ROWS = {message.name: message for message in messages.MESSAGES}


def _feed(decoder, data):
    # The frames in `data`: copies of what the decoder held at each.
    found = []
    for byte in data:
        if decoder.feed(byte):
            found.append(bytes(decoder.buf[: decoder.length]))
    return found


def _decoder(seed=SEED):
    decoder = frame.Decoder()
    decoder.session = OneSeed(seed)
    return decoder


def test_crc_of_the_check_string():
    assert crc.make_seed(b"123456789") == CRC_CHECK.to_bytes(4, "little")


def test_crc_known_answers_seeded_and_not():
    for data, seed, result in CRCS:
        buf = bytearray(data + b"\x55" * 4)
        crc.append(buf, len(data), bytes.fromhex(seed))
        assert bytes(buf) == data + bytes.fromhex(result), (data, seed)
        assert crc.check(buf, len(buf), bytes.fromhex(seed))


def test_crc_check_refuses_each_wrong_byte_and_a_wrong_seed():
    buf = bytearray(b"gazechair" + bytes(4))
    crc.append(buf, 9, SEED)
    assert not crc.check(buf, 13, crc.NO_SEED)
    for at in range(13):
        buf[at] ^= 0x80
        assert not crc.check(buf, 13, SEED), at
        buf[at] ^= 0x80
    assert crc.check(buf, 13, SEED)


def test_crc_check_refuses_what_is_shorter_than_a_crc():
    for n in range(4):
        assert not crc.check(bytearray(4), n, crc.NO_SEED)


def test_the_table_has_the_hash_both_ends_expect():
    assert frame.schema_hash().to_bytes(4, "little") == bytes.fromhex(SCHEMA_HASH)


def test_session_seed_known_answers():
    for session, boot, nonce, epoch, seed in SEEDS:
        keys = frame.Session()
        keys.begin(session, boot, bytes.fromhex(nonce), epoch, 0x1234)
        assert keys.seed(0x1234) == bytes.fromhex(seed)


def test_a_stamp_means_the_moment_nearest_to_the_clock():
    # Rounds of the stamp before and after a wrap, each with a seed of its own; no two are alike.
    keys = frame.Session()
    keys.begin(1, 2, b"\x03\x04\x05\x06", 7, 0xFFF0)
    now = bytes(keys.seed(0xFFF0))
    after = bytes(keys.seed(0x0010))
    assert now != after
    assert bytes(keys.seed(0x7FF0)) == now
    assert bytes(keys.seed(0x7FEF)) == after
    keys.advance(0xFFE0)  # an older one changes nothing
    assert (keys.epoch, keys.clock_ms) == (7, 0xFFF0)
    keys.advance(0x0010)
    assert (keys.epoch, keys.clock_ms) == (8, 0x0010)
    assert bytes(keys.seed(0x0010)) == after
    assert bytes(keys.seed(0xFFF0)) == now
    assert bytes(keys.seed(0x8010)) == now
    keys.advance(0x7000)
    keys.advance(0xE000)
    keys.advance(0x0010)  # 65536 ms later
    assert bytes(keys.seed(0x0010)) not in (now, after)
    assert bytes(keys.seed(0xFFF0)) == after


def test_seeds_are_kept_without_allocation():
    keys = frame.Session()

    def a_life():
        keys.begin(1, 2, b"\x03\x04\x05\x06", 7, 0xFFF0)
        for k in range(40):
            keys.advance((0xFFF0 + 7000 * k) & 0xFFFF)
            keys.seed(0x1234)
        keys.end()

    no_allocation(a_life)


def test_every_message_has_a_known_frame():
    assert sorted(name for name, _, _, _, _ in FRAMES) == sorted(ROWS)


def test_encoding_gives_the_known_frames():
    for name, seq, stamp_ms, values, wire in FRAMES:
        encoder = frame.Encoder()
        encoder.session = OneSeed(SEED)
        encoder._seq = (seq - 1) & 0xFF
        ROWS[name].pack(encoder.body, values)
        n = encoder.finish(ROWS[name], stamp_ms)
        assert bytes(encoder.wire[:n]) == bytes.fromhex(wire), name


def test_decoding_the_known_frames_gives_the_values():
    decoder = _decoder()
    for name, seq, stamp_ms, values, wire in FRAMES:
        found = _feed(decoder, bytes.fromhex(wire))
        assert len(found) == 1, name
        message = messages.BY_TYPE[found[0][messages.TYPE_AT]]
        assert message.name == name
        assert found[0][messages.SEQ_AT] == seq
        assert frame.u16(found[0], messages.STAMP_AT) == stamp_ms
        assert message.unpack(found[0]) == dict(zip(message.names, values)), name
    assert (decoder.ok, decoder.corrupt, decoder.unknown) == (len(FRAMES), 0, 0)


def test_offsets_read_the_same_as_unpack():
    for name, _, _, values, wire in FRAMES:
        found = _feed(_decoder(), bytes.fromhex(wire))[0]
        for field, value in zip(ROWS[name].names, values):
            at = ROWS[name].offsets[field]
            if isinstance(value, int) and -32768 <= value <= 32767:
                letter = ROWS[name].fields.split(field + ":")[1][0]
                read = {"B": lambda b, a: b[a], "H": frame.u16, "h": frame.i16}.get(letter)
                assert read is None or read(found, at) == value, (name, field)


def test_sequence_numbers_wrap():
    encoder = frame.Encoder()
    encoder.session = OneSeed(SEED)
    decoder = _decoder()
    seen = []
    for _ in range(258):
        n = encoder.finish(messages.PING, 0)
        seen.append(_feed(decoder, encoder.wire[:n])[0][messages.SEQ_AT])
    assert seen[0] == 1
    assert seen[254:] == [255, 0, 1, 2]


def test_without_a_session_only_plain_messages_can_be_sent():
    encoder = frame.Encoder()
    encoder.session = frame.Session()
    for message in messages.MESSAGES:
        if message.plain:
            assert encoder.finish(message, 0) > 0
        else:
            assert "no session" in raises(ValueError, encoder.finish, message, 0)


def test_frames_fit_and_state_stays_small():
    for message in messages.MESSAGES:
        assert message.size + crc.CRC_SIZE + 2 <= frame.MAX_WIRE
    assert messages.STATE.size + crc.CRC_SIZE + 2 <= 26


def test_decoding_allocates_nothing_whatever_comes():
    decoder = _decoder()
    stream = bytearray()
    for _, _, _, _, wire in FRAMES:
        stream += bytes.fromhex(wire)
    corrupt = bytearray(bytes.fromhex(FRAMES[0][4]))
    corrupt[5] ^= 1
    stream += corrupt + bytes(9) + b"\x05" * 90 + b"\x00\xff\x01\x00\x03\x01\x00\x09\x7f\x00"

    def feed_all():
        for byte in stream:
            decoder.feed(byte)

    no_allocation(feed_all)
    assert decoder.ok % len(FRAMES) == 0
    assert decoder.ok
    assert decoder.corrupt


def test_encoding_allocates_nothing():
    encoder = frame.Encoder()
    encoder.session = OneSeed(SEED)

    def encode_all():
        for message in messages.MESSAGES:
            encoder.finish(message, 65535)

    no_allocation(encode_all)


def test_reading_fields_allocates_nothing():
    buf = bytearray(b"\xff" * 62)

    def read():
        total = 0
        for at in range(60):
            total += frame.u16(buf, at) + frame.i16(buf, at)
        return total

    no_allocation(read)
