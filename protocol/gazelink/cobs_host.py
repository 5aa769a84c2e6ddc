"""COBS encoding in plain Python, for CPython."""

from typing import Union

Buffer = Union[bytes, bytearray]


def encode(src: Buffer, n: int, dst: bytearray) -> int:
    """Stuff src[0:n] (n <= 62) into dst, delimiter included; returns the bytes written, n + 2."""
    code_at = 0
    code = 1
    for i in range(n):
        if src[i]:
            dst[i + 1] = src[i]
            code += 1
        else:
            dst[code_at] = code
            code_at = i + 1
            code = 1
    dst[code_at] = code
    dst[n + 1] = 0
    return n + 2
