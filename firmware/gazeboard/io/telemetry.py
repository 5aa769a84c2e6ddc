# STATE frames: the tick captures them, the service loop sends them.
#
# The tick captures one when it is due, with the wipers' counts; the service loop sends it, with the
# deflection they mean, when the line is free. No allocation; the tick writes `head` last, only the
# service loop moves `tail`.

from gazeboard.io.joystick import permille
from gazelink import codes
from gazelink.const import const
from gazelink.messages import HEADER_SIZE, STATE
from gazelink.native import micropython, ptr8

PERIOD_MS = 10  # unless the host requests another, 1..100
_SLOTS = const(64)  # at a frame a millisecond: longer than two collections of garbage take
_SLOT = const(16)
_ALL_UNKNOWN = const(255)  # codes.UNKNOWN in all four fields
_NEWEST_ONLY_MS = 5  # a period of this or more: what waited is skipped, the newest goes
assert STATE.format == "<BBBBIHhhBB"  # capture() and take() write these fields
_LINEAR_AT = const(10)  # in a slot: a count
_TURN_AT = const(11)
_TOLD_AT = STATE.offsets["linear_permille"]


class Telemetry:
    def __init__(self, safety, joystick, obstacles):
        self._joystick = joystick
        self._slots = bytearray(_SLOTS * _SLOT)
        self._captured = (safety, joystick, obstacles, self._slots)  # found at once in the tick
        self._head = 0
        self._tail = 0
        self._due = 0
        self.period_ms = PERIOD_MS
        self.dropped = 0  # due, but the line was too slow

    # In the tick: `ticks` is its number, `motion` the motion's state, heading in 1/16 degree.
    @micropython.viper
    def capture(self, ticks: int, motion: int, heading_q4: int):
        behind = (ticks - int(self._due)) & 0x3FFFFFFF
        if behind >= 0x20000000:  # not due yet
            return
        period_ms = int(self.period_ms)
        if behind:
            behind = behind % period_ms
        self._due = (ticks + period_ms - behind) & 0x3FFFFFFF
        head = int(self._head)
        if (head - int(self._tail)) & 0xFF >= _SLOTS:
            self.dropped = (int(self.dropped) + 1) & 0xFFFF
            return
        s, joystick, obstacles, slots = self._captured
        faults = int(s.faults)
        edge = int(s.edge)
        if edge == 0:
            edge = int(s.spent_edge)
        decisions = _ALL_UNKNOWN
        if faults & (1 << int(codes.OBSTACLE_DATA_OLD)) == 0:
            decisions = int(obstacles.decisions)
        b = ptr8(slots)
        at = (head & (_SLOTS - 1)) * _SLOT
        b[at] = int(s.state) | (motion << 4)
        b[at + 1] = int(s.override)
        b[at + 2] = int(s.arm_reason)
        b[at + 3] = int(s.first_fault)
        b[at + 4] = faults & 0xFF
        b[at + 5] = (faults >> 8) & 0xFF
        b[at + 6] = (faults >> 16) & 0xFF
        b[at + 7] = (faults >> 24) & 0xFF
        b[at + 8] = heading_q4 & 0xFF
        b[at + 9] = heading_q4 >> 8
        b[at + 10] = int(joystick.linear_wiper)
        b[at + 11] = int(joystick.turn_wiper)
        b[at + 12] = edge
        b[at + 13] = decisions
        b[at + 14] = ticks & 0xFF
        b[at + 15] = (ticks >> 8) & 0xFF
        self._head = (head + 1) & 0xFF

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
        for k in range(_LINEAR_AT):
            body[HEADER_SIZE + k] = b[at + k]
        stick = self._joystick
        linear = permille(b[at + _LINEAR_AT], stick.neutral_linear)
        turn = permille(b[at + _TURN_AT], stick.neutral_turn)
        body[_TOLD_AT] = linear & 0xFF
        body[_TOLD_AT + 1] = (linear >> 8) & 0xFF
        body[_TOLD_AT + 2] = turn & 0xFF
        body[_TOLD_AT + 3] = (turn >> 8) & 0xFF
        body[_TOLD_AT + 4] = b[at + 12]
        body[_TOLD_AT + 5] = b[at + 13]
        stamp_ms = b[at + 14] | (b[at + 15] << 8)
        self._tail = (self._tail + 1) & 0xFF
        return stamp_ms

    # A new session: nothing of the old one is sent, the period is the usual one.
    def restart(self):
        self.period_ms = PERIOD_MS
        self.forget()

    # What waits was captured under another neutral, or for another host.
    def forget(self):
        self._tail = self._head
