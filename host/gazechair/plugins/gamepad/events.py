"""The kernel's input events: struct input_event, from a device or as recorded bytes. Pure."""

from __future__ import annotations

import struct

EVENT = struct.Struct("llHHi")  # seconds, microseconds, type, code, value
SYN, KEY, ABS = 0, 1, 3
REPORT, DROPPED = 0, 3
X, Y, RX, RY, HAT_X, HAT_Y = 0, 1, 3, 4, 16, 17
# The first button of a joystick (trigger) and of a gamepad (A, cross).
FIRST_BUTTONS = (0x120, 0x130)
AXES = (X, Y, RX, RY, HAT_X, HAT_Y)

Range = tuple[int, int]


def event(kind: int, code: int, value: int, time_s: float = 0.0) -> bytes:
    """One event as bytes."""
    return EVENT.pack(int(time_s), int(time_s % 1 * 1_000_000), kind, code, value)


class PadState:
    """Axes within -1..1 and buttons, as of the last complete report."""

    def __init__(self, ranges: dict[int, Range]) -> None:
        """`ranges`: least and greatest value of each axis there is."""
        self._ranges = {axis: r for axis, r in ranges.items() if r[0] < r[1]}
        self.axes = dict.fromkeys(AXES, 0.0)
        self.buttons: set[int] = set()
        self.lost = False
        """True if the kernel dropped events: the state is unknown until each axis is read again."""
        self._rest = b""
        self._axes = dict(self.axes)
        self._buttons: set[int] = set()

    def feed(self, data: bytes) -> None:
        """Process bytes from the device, split anywhere."""
        data = self._rest + data
        whole = len(data) - len(data) % EVENT.size
        self._rest = data[whole:]
        for _s, _us, kind, code, value in EVENT.iter_unpack(data[:whole]):
            self._take(kind, code, value)

    def put(self, axis: int, value: int) -> None:
        """Set the position of an axis, as read from the device."""
        self._move(axis, value)
        self.axes = dict(self._axes)

    def _take(self, kind: int, code: int, value: int) -> None:
        if kind == ABS:
            self._move(code, value)
        elif kind == KEY and value:
            self._buttons.add(code)
        elif kind == KEY:
            self._buttons.discard(code)
        elif kind == SYN and code == DROPPED:
            self.lost = True
        elif kind == SYN and code == REPORT:
            if self.lost:
                self._axes = dict.fromkeys(AXES, 0.0)
                self._buttons.clear()
            self.axes, self.buttons = dict(self._axes), set(self._buttons)

    def _move(self, axis: int, value: int) -> None:
        if axis in self._axes and axis in self._ranges:
            low, high = self._ranges[axis]
            at = (2.0 * value - low - high) / (high - low)
            self._axes[axis] = max(-1.0, min(at, 1.0))
