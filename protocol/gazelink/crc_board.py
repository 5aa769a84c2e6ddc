# CRC-32 in viper, for MicroPython: no allocation, integers through ptr32.
# Same interface as crc_host.
# ruff: noqa: F821

import array

import micropython


def _make_table():
    table = array.array("I", bytes(1024))
    for n in range(256):
        c = n
        for _ in range(8):
            c = (c >> 1) ^ 0xEDB88320 if c & 1 else c >> 1
        table[n] = c
    return table


_TABLE = _make_table()
_scratch = bytearray(4)
_ZERO = bytes(4)


# Masks after each shift keep signed 32-bit (and 64-bit) machine words equal to the unsigned result.
@micropython.viper
def _crc(buf: ptr8, n: int, seed: ptr8, out: ptr8, table: ptr32):
    c = (int(seed[0]) | (int(seed[1]) << 8) | (int(seed[2]) << 16) | (int(seed[3]) << 24)) ^ -1
    i = 0
    while i < n:
        c = int(table[(c ^ int(buf[i])) & 0xFF]) ^ ((c >> 8) & 0xFFFFFF)
        i += 1
    c = c ^ -1
    out[0] = c & 0xFF
    out[1] = (c >> 8) & 0xFF
    out[2] = (c >> 16) & 0xFF
    out[3] = (c >> 24) & 0xFF


def fill_seed(data, seed):
    _crc(data, len(data), _ZERO, seed, _TABLE)


def append(buf, n, seed):
    _crc(buf, n, seed, _scratch, _TABLE)
    buf[n] = _scratch[0]
    buf[n + 1] = _scratch[1]
    buf[n + 2] = _scratch[2]
    buf[n + 3] = _scratch[3]


def check(buf, n, seed):
    if n < 4:
        return False
    _crc(buf, n - 4, seed, _scratch, _TABLE)
    return (
        buf[n - 4] == _scratch[0]
        and buf[n - 3] == _scratch[1]
        and buf[n - 2] == _scratch[2]
        and buf[n - 1] == _scratch[3]
    )
