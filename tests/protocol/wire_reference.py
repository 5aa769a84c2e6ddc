"""The wire once more, written plainly from its description: what gazelink is compared with."""

import struct
import zlib


def cobs(data: bytes) -> bytes:
    """Consistent overhead byte stuffing of up to 253 bytes, delimiter included."""
    stuffed = b"".join(bytes([len(part) + 1]) + part for part in data.split(b"\0"))
    return stuffed + b"\0"


def frame(
    type_id: int, seq: int, stamp_ms: int, payload: bytes, seed: bytes = b"\0\0\0\0"
) -> bytes:
    """One frame as it goes over the wire; `seed` is the CRC's starting value, little-endian."""
    body = struct.pack("<BBH", type_id, seq, stamp_ms) + payload
    crc = zlib.crc32(body, int.from_bytes(seed, "little"))
    return cobs(body + struct.pack("<I", crc))


def seed(schema: str, session: int, boot: int, nonce: bytes, epoch: int) -> bytes:
    """CRC starting value: of the table's hash, the ids, the nonce and the round of the stamp."""
    ids = struct.pack("<IHH4sI", zlib.crc32(schema.encode()), session, boot, nonce, epoch)
    return struct.pack("<I", zlib.crc32(ids))
