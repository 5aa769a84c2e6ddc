"""Random and mutated streams for GAZECHAIR_FUZZ_S seconds (default 2): pytest -m fuzz."""

import os
import random
import time

import pytest

from wire_damage import SEED, WIRES, feed, judged, new_decoder, pieces

FUZZ_S = float(os.environ.get("GAZECHAIR_FUZZ_S", "2"))
# A damaged frame passes a CRC-32 once in 4e9: none is to be expected in days of fuzzing.
GOOD = {found for wire in WIRES.values() for found in feed(new_decoder(), wire)}


def mutate(rng: random.Random, data: bytearray) -> None:
    """Damage `data` in one of the ways a bad cable or a bad program does."""
    at = rng.randrange(len(data))
    kind = rng.randrange(6)
    if kind == 0:
        data[at] ^= 1 << rng.randrange(8)
    elif kind == 1:
        del data[at : at + rng.randrange(1, 9)]
    elif kind == 2:
        data[at:at] = rng.randbytes(rng.randrange(1, 9))
    elif kind == 3:
        data[at:at] = data[at : at + rng.randrange(1, 70)]
    elif kind == 4:
        data[at : at + 4] = bytes(rng.randrange(1, 5))
    else:
        data[at] = rng.choice((0, 1, 2, 62, 63, 64, 254, 255))


@pytest.mark.fuzz
def test_nothing_false_is_taken_and_every_piece_is_counted() -> None:
    """No exception, no frame that was not sent, and counters that add up."""
    seed = random.randrange(1 << 32)
    rng = random.Random(seed)
    wires = list(WIRES.values())
    end = time.monotonic() + FUZZ_S
    streams = 0
    while streams == 0 or time.monotonic() < end:
        stream = bytearray(rng.randbytes(rng.randrange(100)))
        for _ in range(rng.randrange(1, 12)):
            stream += rng.choice(wires)
        for _ in range(rng.randrange(12)):
            if stream:
                mutate(rng, stream)
        decoder = new_decoder(rng.choice((SEED, None)))
        found = feed(decoder, stream)
        why = f"random seed {seed}, stream {streams}: {stream.hex()}"
        assert GOOD.issuperset(found), why
        assert decoder.ok == len(found), why
        assert judged(decoder) == pieces(bytes(stream)), why
        streams += 1
    print(f"{streams} streams, random seed {seed}")
