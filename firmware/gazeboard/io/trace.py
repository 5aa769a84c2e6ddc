# The trace: what the ticks took, for the host's log; gazereplay plays it through the core again.
#
# Only on request. The tick records when contacts, wipers or pace are not as usual, and marks the
# inputs that it takes; the service loop writes both into a ring of bytes, which go out when the
# line has nothing else to send. What does not fit is lost, is said to be lost, and the next
# snapshot begins anew. No allocation.
#
# A record is a kind, the tick as u16, then what the kind says. tools/gazereplay/stream.py reads it.

from array import array

from gazeboard.core.shared import Inputs
from gazelink import arcs
from gazelink.const import const
from gazelink.messages import TRACE
from gazelink.native import micropython, ptr8, ptr32

SNAPSHOT = const(1)  # the high half of its tick, 1 after a loss, AROUND, count of words, the words
INPUTS = const(2)  # first seen in that tick: changes of the words since the record before
AROUND = const(3)  # first in that tick: bits as in saw()
SILENT = const(4)  # the service loop's sign of life, and the next one's tick
FIELDS = tuple(name for name in Inputs.FIELDS if name != "service_count")
WORDS = len(FIELDS) + arcs.SIZE  # of the inputs

# Trace.on:
OFF = const(0)
ON = const(1)
ODD = const(2)  # and something was not as usual around the last tick

_RELAY = const(1)
_VERIFIED = const(8)
_MASK = const(0x3FFFFFFF)
_EVENTS = const(64)
_SIZE = const(8192)  # of the ring, bytes
_SNAPSHOT_MOST = const(7600)
_RECORD_MOST = const(420)
_SILENT_MS = const(16)  # less is no matter to the core: a third of SERVICE_STALLED_MS
_PART = TRACE.offsets["part"]
_BEGINS = TRACE.offsets["begins"]
_DATA = TRACE.offsets["data"]
DATA_SIZE = TRACE.size - _DATA
NO_BEGIN = const(255)
# The tick's words; then the events, a tick and what was around it each.
_LAST = const(0)
_HEAD = const(1)
_TAIL = const(2)
_LOST = const(3)
_RING = const(4)


class Trace:
    def __init__(self, outbox):
        self.on = OFF
        self._outbox = outbox
        self._words = array("i", [0] * (_RING + 2 * _EVENTS))
        self._state = None
        self._now = array("i", [0] * WORDS)
        self._old = array("i", [0] * WORDS)
        self._bytes = bytearray(_SIZE)
        self._head = 0
        self._tail = 0
        self._part = 0
        self._snapshot_at = -1  # where in the stream of bytes the newest begins
        self._due = False  # a snapshot
        self._lost = False
        self._until = 0  # the newest event when inputs were about to be replaced, and the tick then
        self._ticks = 0
        self._beat_at = 0

    # -- the tick ----------------------------------------------------------------------------------

    # What is around tick `ticks`; called when it is not as usual, or was not in the tick before.
    @micropython.viper
    def saw(
        self,
        ticks: int,
        relay_closed: int,
        emergency_open: int,
        button_pressed: int,
        verified: int,
        late: int,
        missed_ms: int,
    ) -> int:
        w = ptr32(self._words)
        around = relay_closed | (emergency_open << 1) | (button_pressed << 2) | (verified << 3)
        around |= (late << 4) | (missed_ms << 5)
        if around != w[_LAST]:
            w[_LAST] = around
            head = w[_HEAD]
            if (head - w[_TAIL]) & 0xFF >= _EVENTS:
                w[_LOST] = 1
            else:
                at = _RING + 2 * (head & (_EVENTS - 1))
                w[at] = ticks
                w[at + 1] = around
                w[_HEAD] = (head + 1) & 0xFF
        return ON if around | _RELAY == _RELAY | _VERIFIED else ODD

    # -- the service loop --------------------------------------------------------------------------

    # The host's request: go on from a new snapshot, or stop.
    def ask(self, on):
        if not (on and self.on):
            self.on = ODD if on else OFF
            w = self._words
            w[_LAST] = -1  # the next tick says what is around it
            w[_TAIL] = w[_HEAD]
            self._tail = self._head
            self._part = (self._part + 1) & 0xFFFF  # what waited is lost
            self._beat_at = self._outbox.ticks
            self._lost = True
        self._due = True

    # The parts of the core are others now. Only while disarmed.
    def follow(self, state):
        self._state = state
        self.lose()

    # Something was missed: only a snapshot helps.
    def lose(self):
        self._lost = True

    # A sign of life was about to be given at `ticks`.
    def beat(self, ticks):
        if (ticks - self._beat_at) & _MASK > _SILENT_MS:
            if ticks != self._outbox.ticks:  # a tick came in between, and which it saw is not known
                self._lost = True
            elif self._fits(_RECORD_MOST):
                self._begin(SILENT, self._beat_at)
                self._put(ticks, 2)
        self._beat_at = ticks

    # The inputs are about to be replaced.
    def hold(self):
        self._until = self._words[_HEAD]
        self._ticks = self._outbox.ticks

    # They have been, `old` by `new`, which no tick has seen before hold().
    def replaced(self, old, new):
        w = self._words
        if w[_LOST]:
            w[_LOST] = 0
            self._lost = True
        at = old.taken_at
        if at >= 0:
            self._drain(at)
            if self._fits(_RECORD_MOST):
                self._begin(INPUTS, at)
                self._put_inputs(old)
        self._drain(-1)
        if self._due or self._lost:
            self._snapshot(new)

    # The events up to hold(), to tick `last` if that is one.
    def _drain(self, last):
        w = self._words
        tail = w[_TAIL]
        while tail != self._until:
            at = _RING + 2 * (tail & (_EVENTS - 1))
            if last >= 0 and (last - w[at]) & _MASK >= 0x20000000:
                break
            if self._fits(_RECORD_MOST):
                self._begin(AROUND, w[at])
                self._put(w[at + 1], 2)
            tail = (tail + 1) & 0xFF
        w[_TAIL] = tail

    # Whole, or not at all: with the next inputs then.
    def _snapshot(self, new):
        w = self._words
        state = self._state
        if w[_LAST] < 0 or self._room() < _SNAPSHOT_MOST:
            return
        state.take()
        if self._outbox.ticks != self._ticks or w[_HEAD] != self._until:
            return
        self._snapshot_at = self._head
        count = len(state.words)
        self._begin(SNAPSHOT, self._ticks)
        self._put(self._ticks >> 16, 2)
        self._put(self._lost, 1)
        self._put(w[_LAST], 2)
        self._put(count, 2)
        self._head = _pack(state.words, state.words, count, 2, self._bytes, self._head)
        self._due = self._lost = False
        for k in range(WORDS):
            self._old[k] = 0
        self._begin(INPUTS, self._ticks + 1)
        self._put_inputs(new)

    def _put_inputs(self, i):
        i.as_words(self._now)
        self._head = _pack(self._now, self._old, WORDS, 0, self._bytes, self._head)

    def _room(self):
        return _SIZE - ((self._head - self._tail) & _MASK)

    # After a loss nothing is written before a snapshot.
    def _fits(self, size):
        if self._room() < size:
            self._lost = True
        return not self._lost

    def _begin(self, kind, ticks):
        self._put(kind, 1)
        self._put(ticks, 2)

    def _put(self, number, size):
        self._head = _write(self._bytes, self._head, number, size)

    # -- to the line -------------------------------------------------------------------------------

    # A frame is full.
    def waits(self):
        return (self._head - self._tail) & _MASK >= DATA_SIZE

    # Fill a frame's body.
    def take(self, body):
        tail = self._tail
        begins = (self._snapshot_at - tail) & _MASK
        body[_PART] = self._part & 0xFF
        body[_PART + 1] = self._part >> 8
        body[_BEGINS] = begins if begins < DATA_SIZE else NO_BEGIN
        _copy(self._bytes, tail, body, _DATA, DATA_SIZE)
        self._tail = (tail + DATA_SIZE) & _MASK
        self._part = (self._part + 1) & 0xFFFF


@micropython.viper
def _copy(ring, tail: int, body, at: int, size: int):
    r = ptr8(ring)
    b = ptr8(body)
    k = 0
    while k < size:
        b[at + k] = r[(tail + k) & (_SIZE - 1)]
        k += 1


# The low bytes of `number`, the lowest first. Returns the place behind them.
@micropython.viper
def _write(ring, at: int, number: int, size: int) -> int:
    b = ptr8(ring)
    while size:
        b[at & (_SIZE - 1)] = number & 0xFF
        number >>= 8
        at += 1
        size -= 1
    return at & 0x3FFFFFFF


# Differences of `words`, as zigzag varints, a run of zeros as 0 and its length: to the word `lag`
# before, or with none to `old`, which then becomes `words`. Returns the place behind them.
@micropython.viper
def _pack(words, old, count: int, lag: int, ring, at: int) -> int:
    w = ptr32(words)
    o = ptr32(old)
    b = ptr8(ring)
    mask = _SIZE - 1
    zeros = 0
    k = 0
    while k <= count:
        change = 1  # ends the last run
        if k < count:
            change = w[k]
            if lag == 0:
                change -= o[k]
                o[k] = w[k]
            elif k >= lag:
                change -= w[k - lag]
        if change == 0:
            zeros += 1
        if zeros and (change or zeros == 255):
            b[at & mask] = 0
            b[(at + 1) & mask] = zeros
            at += 2
            zeros = 0
        if change and k < count:
            sign = 0
            if change < 0:
                sign = -1
            rest = (change << 1) ^ sign
            while rest & -128:
                b[at & mask] = 128 | (rest & 127)
                at += 1
                rest = (rest >> 7) & 0x1FFFFFF
            b[at & mask] = rest
            at += 1
        k += 1
    return at & 0x3FFFFFFF
