"""Linux services of the virtual board under CPython: memory map, stdio as a serial line, time."""

import mmap
import os
import sys
import time

getenv = os.getenv


def map_file(path, size):
    """The first `size` bytes of the file, shared and writable."""
    with open(path, "r+b") as f:
        return mmap.mmap(f.fileno(), size)


class StdioSerial:
    """stdin and stdout as the board's serial line; the end of the line ends the process."""

    def __init__(self):
        self._in = sys.stdin.fileno()
        self._out = sys.stdout.fileno()
        os.set_blocking(self._in, False)
        os.set_blocking(self._out, False)

    def read_byte(self):
        """The next byte, or -1 when there is none."""
        try:
            data = os.read(self._in, 1)
        except BlockingIOError:
            return -1
        except OSError:
            return -1
        if not data:
            sys.exit(0)
        return data[0]

    def write_some(self, buf, start, end):
        """Write buf[start:end] as far as it goes; the index of the first byte not taken."""
        try:
            return start + os.write(self._out, memoryview(buf)[start:end])
        except OSError:
            return start


def ticks_us():
    """Microseconds, wrapping at 2**30 as on the Teensy."""
    return time.monotonic_ns() // 1000 & 0x3FFFFFFF


def ticks_diff(a, b):
    """a - b in wrapped microseconds, -2**29..2**29-1."""
    return ((a - b + 0x20000000) & 0x3FFFFFFF) - 0x20000000


def sleep_us(us):
    """Wait."""
    time.sleep(us / 1e6)
