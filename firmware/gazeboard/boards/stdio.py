# stdin and stdout as the board's serial line under MicroPython.
#
# USB serial on the Teensy, a pty on Linux. Poll, then exactly one byte: a one-byte read after
# POLLIN and a one-byte write after POLLOUT never block (on mimxrt POLLOUT means room for at least
# one byte, or nobody connected).

import select
import sys

_POLLIN = select.POLLIN
_POLLOUT = select.POLLOUT


class StdioSerial:
    def __init__(self):
        readable = select.poll()
        readable.register(sys.stdin, _POLLIN)
        writable = select.poll()
        writable.register(sys.stdout, _POLLOUT)
        # Bound once: taking a method as a value allocates.
        self._readable = readable.ipoll
        self._writable = writable.ipoll
        self._read_into = sys.stdin.buffer.readinto
        self._write = sys.stdout.buffer.write
        self._one = bytearray(1)

    # The next byte, or -1 when there is none. On Linux the end of the line ends the process.
    def read_byte(self):
        for event in self._readable(0):
            if event[1] & _POLLIN:
                if not self._read_into(self._one):
                    sys.exit(0)
                return self._one[0]
        return -1

    # Writes buf[start:end] as far as the line takes it; returns the index of the first byte it
    # did not take.
    def write_some(self, buf, start, end):
        one = self._one
        write = self._write
        writable = self._writable
        while start < end:
            ready = False
            for event in writable(0):
                ready = event[1] & _POLLOUT
            if not ready:
                break
            one[0] = buf[start]
            if write(one) != 1:
                break
            start += 1
        return start
