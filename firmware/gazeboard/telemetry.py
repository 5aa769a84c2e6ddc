# STATE frames: the tick captures what it found when one is due, the service loop sends it when the
# line is free. No allocation; the tick writes `head` last, the service loop alone moves `tail`.

from gazelink import codes
from gazelink.messages import HEADER_SIZE, STATE
from gazelink.native import micropython

PERIOD_MS = 10  # unless the host asks for another, 1..100
_SLOTS = 32  # at a frame a millisecond: longer than a collection of garbage takes
_SLOT = 16
_ALL_UNKNOWN = 255  # codes.UNKNOWN in all four fields
_PAYLOAD = STATE.size - HEADER_SIZE
_NEWEST_ONLY_MS = 5  # a period of this or more: what waited is skipped, the newest goes
assert _PAYLOAD + 2 <= _SLOT
assert STATE.format == "<BBBBIHBBBB"  # capture() writes these fields


class Telemetry:
    def __init__(self, safety, joystick, obstacles):
        self._safety = safety
        self._joystick = joystick
        self._obstacles = obstacles
        self._slots = bytearray(_SLOTS * _SLOT)
        self._head = 0
        self._tail = 0
        self._due = 0
        self.period_ms = PERIOD_MS
        self.dropped = 0  # due, but the line was too slow

    # In the tick: `ticks` is its number, `motion` the motion's state, heading in 1/16 degree.
    @micropython.native
    def capture(self, ticks, motion, heading_q4):
        behind = (ticks - self._due) & 0x3FFFFFFF
        if behind >= 0x20000000:  # not due yet
            return
        self._due = (ticks + self.period_ms - behind % self.period_ms) & 0x3FFFFFFF
        if (self._head - self._tail) & 0xFF >= _SLOTS:
            self.dropped = (self.dropped + 1) & 0xFFFF
            return
        s = self._safety
        b = self._slots
        at = (self._head & (_SLOTS - 1)) * _SLOT
        faults = s.faults
        b[at] = s.state | (motion << 4)
        b[at + 1] = s.override
        b[at + 2] = s.arm_reason
        b[at + 3] = s.first_fault
        b[at + 4] = faults & 0xFF
        b[at + 5] = (faults >> 8) & 0xFF
        b[at + 6] = (faults >> 16) & 0xFF
        b[at + 7] = faults >> 24
        b[at + 8] = heading_q4 & 0xFF
        b[at + 9] = heading_q4 >> 8
        b[at + 10] = self._joystick.linear_wiper
        b[at + 11] = self._joystick.turn_wiper
        b[at + 12] = s.edge if s.edge else s.spent_edge
        old = faults & (1 << codes.OBSTACLE_DATA_OLD)
        b[at + 13] = _ALL_UNKNOWN if old else self._obstacles.decisions
        b[at + 14] = ticks & 0xFF
        b[at + 15] = (ticks >> 8) & 0xFF
        self._head = (self._head + 1) & 0xFF

    # In the service loop: a captured state waits.
    def waits(self):
        return self._head != self._tail

    # Copy the next one's payload into a frame's body; returns its stamp in ms.
    def take(self, body):
        head = self._head
        if self.period_ms >= _NEWEST_ONLY_MS:
            self.dropped = (self.dropped + ((head - self._tail) & 0xFF) - 1) & 0xFFFF
            self._tail = (head - 1) & 0xFF
        b = self._slots
        at = (self._tail & (_SLOTS - 1)) * _SLOT
        for k in range(_PAYLOAD):
            body[HEADER_SIZE + k] = b[at + k]
        stamp_ms = b[at + 14] | (b[at + 15] << 8)
        self._tail = (self._tail + 1) & 0xFF
        return stamp_ms

    # A new session: nothing of the old one is sent, the period is the usual one.
    def restart(self):
        self.period_ms = PERIOD_MS
        self._tail = self._head
