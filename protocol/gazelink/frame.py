# Framing: COBS with a zero delimiter around header + payload + CRC-32.
#
# No I/O; no allocation after construction.
#
# COBS: Cheshire & Baker, "Consistent Overhead Byte Stuffing", 1997. Bodies are at most 62 bytes, so
# a code byte above 63 never occurs and the 0xFF special case is not needed: such a byte requests
# more than fits, and the frame is rejected for its length.

from gazelink import cobs, crc
from gazelink.messages import BY_TYPE, MESSAGES, SEQ_AT, STAMP_AT, TYPE_AT, schema_text

MAX_WIRE = 64
MAX_BODY = MAX_WIRE - 2  # one COBS code byte, one delimiter

_UNKNOWN = 0
_PLAIN = 1
_SEEDED = 2

# Per type id: what CRC it carries, and its exact size. Bytearrays: a look-up allocates nothing.
_kind = bytearray(256)
_size = bytearray(256)
for _m in MESSAGES:
    _kind[_m.type_id] = _PLAIN if _m.plain else _SEEDED
    _size[_m.type_id] = _m.size
    assert _m.size + crc.CRC_SIZE <= MAX_BODY, _m.name
assert len(BY_TYPE) == len(MESSAGES)

_SCHEMA_SEED = crc.make_seed(schema_text().encode())


def schema_hash():
    # CRC-32 of the message table. Above 30 bits mostly: for HELLO only, never in a hot path.
    return (
        _SCHEMA_SEED[0] | (_SCHEMA_SEED[1] << 8) | (_SCHEMA_SEED[2] << 16) | (_SCHEMA_SEED[3] << 24)
    )


_EPOCHS = 0x3FFFFFFF  # 2000 years of stamps


class Session:
    # The seeds of one session's frames: of the table, the host's session, the board's boot, the
    # nonce the board drew, and the epoch: which round of the 16-bit stamp a frame belongs to. So a
    # frame of another version, host, life of the board, session or round fails its CRC.
    #
    # Both ends count the rounds, as IPsec's extended sequence numbers are counted (RFC 4303): a
    # stamp means the moment nearest to the clock, at most 32.7 s before or after it. Allocates
    # nothing once built.

    def __init__(self):
        self.live = False
        self.epoch = 0
        self.clock_ms = 0  # newest stamp
        self._ids = bytearray(16)
        self._ids[0:4] = _SCHEMA_SEED
        self._before = bytearray(crc.CRC_SIZE)
        self._now = bytearray(crc.CRC_SIZE)
        self._after = bytearray(crc.CRC_SIZE)

    # nonce: 4 bytes; epoch: that of stamp_ms.
    def begin(self, session, boot, nonce, epoch, stamp_ms):
        ids = self._ids
        ids[4] = session & 0xFF
        ids[5] = session >> 8
        ids[6] = boot & 0xFF
        ids[7] = boot >> 8
        for k in range(4):
            ids[8 + k] = nonce[k]
        self.clock_ms = stamp_ms
        self._count(epoch & _EPOCHS)
        self.live = True

    def end(self):
        self.live = False

    # The clock of the session has reached stamp_ms; an older one changes nothing.
    def advance(self, stamp_ms):
        if not 0 < (stamp_ms - self.clock_ms) & 0xFFFF < 0x8000:
            return
        around = stamp_ms < self.clock_ms
        self.clock_ms = stamp_ms
        if around:
            self._count((self.epoch + 1) & _EPOCHS)

    # Seed of a frame with that stamp; None outside a session.
    def seed(self, stamp_ms):
        if not self.live:
            return None
        ahead = stamp_ms - self.clock_ms
        if ahead >= 0x8000:
            return self._before
        return self._now if ahead >= -0x8000 else self._after

    def _count(self, epoch):
        self.epoch = epoch
        self._fill((epoch - 1) & _EPOCHS, self._before)
        self._fill(epoch, self._now)
        self._fill((epoch + 1) & _EPOCHS, self._after)

    def _fill(self, epoch, seed):
        ids = self._ids
        for k in range(4):
            ids[12 + k] = (epoch >> (8 * k)) & 0xFF
        crc.fill_seed(ids, seed)


class Decoder:
    # Feed it bytes one at a time. True means: buf[0:length] holds one whole, checked frame of a
    # known type and exact size, valid until the next feed. All else is counted and dropped.

    def __init__(self):
        self.buf = bytearray(MAX_BODY)
        self.length = 0  # of the last good frame, CRC not counted
        self.session = None  # a Session; None: plain frames only
        self.ok = 0
        self.corrupt = 0  # bad stuffing, size or CRC (a foreign session's too)
        self.unknown = 0  # right CRC, a type or size that is not in the table
        self._n = 0
        self._left = 0
        self._started = False
        self._bad = False

    def feed(self, byte):
        if byte == 0:
            whole = self._started and not self._bad and self._left == 0
            started = self._started
            n = self._n
            self._n = 0
            self._left = 0
            self._started = False
            self._bad = False
            if whole:
                return self._accept(n)
            if started:
                self.corrupt = (self.corrupt + 1) & 0xFFFF
            return False
        if self._bad:
            return False
        if self._left == 0:
            if self._started:
                self._put(0)
            self._started = True
            self._left = byte - 1
        else:
            self._left -= 1
            self._put(byte)
        return False

    def _put(self, byte):
        n = self._n
        if n >= MAX_BODY:
            self._bad = True
            return
        self.buf[n] = byte
        self._n = n + 1

    def _accept(self, n):
        kind = _kind[self.buf[TYPE_AT]]
        seed = None if self.session is None else self.session.seed(u16(self.buf, STAMP_AT))
        if kind == _UNKNOWN and seed is not None and crc.check(self.buf, n, seed):
            self.unknown = (self.unknown + 1) & 0xFFFF
            return False
        if kind != _SEEDED:
            seed = crc.NO_SEED
        if seed is None or not crc.check(self.buf, n, seed):
            self.corrupt = (self.corrupt + 1) & 0xFFFF
            return False
        if kind == _UNKNOWN or n - crc.CRC_SIZE != _size[self.buf[TYPE_AT]]:
            self.unknown = (self.unknown + 1) & 0xFFFF
            return False
        self.length = n - crc.CRC_SIZE
        self.ok = (self.ok + 1) & 0xFFFF
        return True


class Encoder:
    # Write the payload into `body` (offsets of the message table), then finish(): `wire[0:n]` is
    # the frame.

    def __init__(self):
        self.body = bytearray(MAX_BODY)
        self.wire = bytearray(MAX_WIRE)
        self.session = None  # as the decoder's
        self._seq = 0

    def finish(self, message, stamp_ms):
        # Number of bytes in `wire`. Raises ValueError for a seeded message before a session exists.
        body = self.body
        seed = crc.NO_SEED
        if not message.plain:
            seed = None if self.session is None else self.session.seed(stamp_ms)
        if seed is None:
            raise ValueError("no session yet: only plain messages can be sent")
        self._seq = (self._seq + 1) & 0xFF
        body[TYPE_AT] = message.type_id
        body[SEQ_AT] = self._seq
        body[STAMP_AT] = stamp_ms & 0xFF
        body[STAMP_AT + 1] = (stamp_ms >> 8) & 0xFF
        crc.append(body, message.size, seed)
        return cobs.encode(body, message.size + crc.CRC_SIZE, self.wire)


def u16(buf, at):
    return buf[at] | (buf[at + 1] << 8)


def i16(buf, at):
    value = buf[at] | (buf[at + 1] << 8)
    return value - 65536 if value & 0x8000 else value
