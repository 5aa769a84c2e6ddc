# Duration of small corrections from rest.
#
# The model is least accurate for them: when the chair breaks loose, and the floor's effect
# meanwhile. The intended and the actual effect of the last one limit how long the next one to that
# side lasts. Integers, no allocation.

from gazelink.const import const
from gazelink.native import micropython

_LONGER_MS = const(30)
_ENDLESS_MS = const(9999)


class SmallMoves:
    # careful: the newest judged move had far too much effect; the correction back aims at half.

    def __init__(self):
        self.start()

    # A turn begins.
    @micropython.native
    def start(self):
        self.careful = False
        self._bounded = False  # the last move was one of these
        self._side = 0  # of the last move
        self._asked_q8 = 0
        self._ms = 0
        self._low_ms = 0
        self._high_ms = _ENDLESS_MS

    # A move begins, left_q8 from there, to `side` (1: left). bounded: it is small and from rest.
    @micropython.native
    def begin(self, left_q8, side, bounded):
        last = self._side
        if self._bounded:
            asked_q8 = self._asked_q8 * last
            done_q8 = asked_q8 - left_q8 * last
            self.careful = done_q8 > asked_q8 + (asked_q8 >> 1)
            if self.careful:
                self._high_ms = min(self._high_ms, self._ms)
            elif done_q8 < asked_q8 >> 1:
                self._low_ms = max(self._low_ms, self._ms)
        if side != last:
            self._side = side
            self._low_ms = 0
            self._high_ms = _ENDLESS_MS
        self._bounded = bounded
        self._asked_q8 = left_q8
        self._ms = 0

    # A tick of a move: whether it ends now. as_planned: by the model.
    @micropython.native
    def ends(self, as_planned):
        if not self._bounded:
            return as_planned
        ms = self._ms + 1
        self._ms = ms
        low_ms = self._low_ms
        if low_ms:
            if ms < low_ms + _LONGER_MS:
                as_planned = False
            elif ms >= low_ms + 3 * _LONGER_MS:
                as_planned = True
        return as_planned or ms + (_LONGER_MS >> 1) >= self._high_ms
