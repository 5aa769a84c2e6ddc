# COBS encoding in viper, for MicroPython: no allocation. Same interface as cobs_host.
# ruff: noqa: F821

import micropython


@micropython.viper
def encode(src: ptr8, n: int, dst: ptr8) -> int:
    code_at = 0
    code = 1
    i = 0
    while i < n:
        byte = int(src[i])
        i += 1
        if byte:
            dst[i] = byte
            code += 1
        else:
            dst[code_at] = code
            code_at = i
            code = 1
    dst[code_at] = code
    dst[n + 1] = 0
    return n + 2
