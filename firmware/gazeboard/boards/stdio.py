# stdin and stdout as the board's serial line, under MicroPython: USB serial on the Teensy, a pty on
# Linux.
#
# Poll, then exactly one byte: a one-byte read after POLLIN and a one-byte write after POLLOUT never
# block (on mimxrt POLLOUT means room for at least one byte, or nobody connected).

import select
import sys


class StdioSerial:
    def __init__(self):
        self._in = sys.stdin.buffer
        self._out = sys.stdout.buffer
        self._readable = select.poll()
        self._readable.register(sys.stdin, select.POLLIN)
        self._writable = select.poll()
        self._writable.register(sys.stdout, select.POLLOUT)
        self._one = bytearray(1)

    # The next byte, or -1 when there is none. On Linux the end of the line ends the process.
    def read_byte(self):
        for event in self._readable.ipoll(0):
            if event[1] & select.POLLIN:
                if not self._in.readinto(self._one):
                    sys.exit(0)
                return self._one[0]
        return -1

    # True when the line took the byte; False: try again later.
    def write_byte(self, byte):
        for event in self._writable.ipoll(0):
            if event[1] & select.POLLOUT:
                self._one[0] = byte
                return self._out.write(self._one) == 1
        return False
