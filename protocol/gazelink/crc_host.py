"""CRC-32 with zlib, for CPython."""

import zlib
from typing import Union

Buffer = Union[bytes, bytearray]


def fill_seed(data: Buffer, seed: bytearray) -> None:
    """Write the CRC-32 of `data` to seed[0:4], little-endian: a seeded CRC starts there."""
    seed[0:4] = zlib.crc32(data).to_bytes(4, "little")


def append(buf: bytearray, n: int, seed: Buffer) -> None:
    """Write the seeded CRC of buf[0:n] to buf[n:n+4], little-endian."""
    start = int.from_bytes(seed, "little")
    buf[n : n + 4] = zlib.crc32(memoryview(buf)[:n], start).to_bytes(4, "little")


def check(buf: Buffer, n: int, seed: Buffer) -> bool:
    """True if buf[0:n] ends in the right seeded CRC; False when it is shorter than one."""
    if n < 4:
        return False
    start = int.from_bytes(seed, "little")
    return zlib.crc32(memoryview(buf)[: n - 4], start) == int.from_bytes(buf[n - 4 : n], "little")
