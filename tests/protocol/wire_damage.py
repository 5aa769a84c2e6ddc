"""Frames and streams for the tests of damage: making them, and what a decoder finds in them."""

from collections.abc import Iterable

from gazelink import frame, messages
from wire_vectors import FRAME_SEED, FRAMES, OneSeed

SEED = bytes.fromhex(FRAME_SEED)
WIRES = {name: bytes.fromhex(wire) for name, _, _, _, wire in FRAMES}
PLAIN = {message.name for message in messages.MESSAGES if message.plain}


def new_decoder(seed: bytes | None = SEED) -> frame.Decoder:
    """A decoder in a session with `seed`; None: before any session."""
    decoder = frame.Decoder()
    decoder.session = None if seed is None else OneSeed(seed)
    return decoder


def feed(decoder: frame.Decoder, data: Iterable[int]) -> list[bytes]:
    """The frames found while feeding `data`, without their CRC."""
    return [bytes(decoder.buf[: decoder.length]) for byte in data if decoder.feed(byte)]


def found_in(data: Iterable[int], seed: bytes | None = SEED) -> list[bytes]:
    """The frames a fresh decoder finds in `data`."""
    return feed(new_decoder(seed), data)


def body(name: str) -> bytes:
    """What the known frame of message `name` decodes to."""
    (found,) = found_in(WIRES[name])
    return found


def judged(decoder: frame.Decoder) -> int:
    """How many pieces the decoder has judged, good and bad."""
    total: int = decoder.ok + decoder.corrupt + decoder.unknown
    return total


def pieces(data: bytes) -> int:
    """Non-empty pieces of `data` that end in a delimiter: each must be judged exactly once."""
    return sum(1 for piece in data.split(b"\0")[:-1] if piece)
