# Duration of small corrections from rest.
#
# The model is least accurate for them: when the chair breaks loose, and the floor's effect
# meanwhile. The intended and the actual effect of the last one limit how long the next one to that
# side lasts. Integers, no allocation.

from array import array

from gazelink.const import const
from gazelink.native import micropython, ptr32

_LONGER_MS = const(30)

# Indices of the words:
_BOUNDED = const(0)  # the last move was one of these
_CAREFUL = const(1)  # the newest judged move had far too much effect
_SIDE = const(2)  # of the last move
_ASKED_Q8 = const(3)
_MS = const(4)
_LOW_MS = const(5)
_WORDS = const(6)


class SmallMoves:
    def __init__(self):
        self._words = array("i", [0] * _WORDS)

    # A turn begins.
    @micropython.viper
    def start(self):
        w = ptr32(self._words)
        at = 0
        while at < _WORDS:
            w[at] = 0
            at += 1

    # A move begins, left_q8 from there, to `side` (1: left). bounded: it is small and from rest.
    @micropython.viper
    def begin(self, left_q8: int, side: int, bounded: int):
        w = ptr32(self._words)
        last = w[_SIDE]
        if w[_BOUNDED]:
            asked_q8 = w[_ASKED_Q8] * last
            done_q8 = asked_q8 - left_q8 * last
            w[_CAREFUL] = 0
            if done_q8 > asked_q8 + (asked_q8 >> 1):
                w[_CAREFUL] = 1
            elif done_q8 < asked_q8 >> 1:
                w[_LOW_MS] = w[_MS]
        if side != last:
            w[_SIDE] = side
            w[_LOW_MS] = 0
        w[_BOUNDED] = bounded
        w[_ASKED_Q8] = left_q8
        w[_MS] = 0

    # What a move has to do of what is left: half of it after one with far too much effect.
    @micropython.viper
    def aim_q8(self, left_q8: int) -> int:
        w = ptr32(self._words)
        if w[_CAREFUL]:
            left_q8 >>= 1
        return left_q8

    # A tick of a move: whether it ends now. as_planned: by the model.
    @micropython.viper
    def ends(self, as_planned: int) -> bool:
        w = ptr32(self._words)
        if w[_BOUNDED] == 0:
            return as_planned != 0
        ms = w[_MS] + 1
        w[_MS] = ms
        low_ms = w[_LOW_MS]
        if low_ms:
            if ms < low_ms + _LONGER_MS:
                as_planned = 0
            elif ms >= low_ms + 3 * _LONGER_MS:
                as_planned = 1
        return as_planned != 0
