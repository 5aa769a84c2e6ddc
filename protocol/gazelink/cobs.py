# Consistent overhead byte stuffing of frames: viper on MicroPython (a frame a millisecond is
# affordable so), plain Python elsewhere. encode(src, n, dst) stuffs src[0:n], at most 62 bytes,
# into dst, delimiter included, and returns the bytes written (n + 2).

import sys

if sys.implementation.name == "micropython":
    from gazelink.cobs_board import encode
else:
    from gazelink.cobs_host import encode

__all__ = ("encode",)
