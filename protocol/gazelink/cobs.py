# Consistent overhead byte stuffing (COBS) of frames.
#
# In viper on MicroPython, so that a frame every millisecond is affordable; in plain Python
# elsewhere. encode(src, n, dst) stuffs src[0:n], at most 62 bytes, into dst, delimiter included,
# and returns the number of bytes written (n + 2).

import sys

if sys.implementation.name == "micropython":
    from gazelink.cobs_board import encode
else:
    from gazelink.cobs_host import encode

__all__ = ("encode",)
