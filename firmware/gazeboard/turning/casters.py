# Model of the casters: the rotation they add to a turn after a reversal.
#
# They swing round over the wheels' distance and turn the chair as well: from their position after a
# right turn (0) to the one after a left turn (the full distance), half a cosine. Integers, no
# allocation.
#
# Their position is known once the chair has turned far enough in one direction. Until then both end
# positions are simulated, and the one nearer to the measured heading counts; while they differ too
# little to distinguish, the one that turns the chair farther.

import array
import math

from gazelink.const import const
from gazelink.native import micropython, ptr32

# Indices of the words.
_LOW = const(0)  # distance from the right's end, 1/256 degree, if they were there
_HIGH = const(1)  # if they lay at the left's
_SEEN = const(2)  # angle of the wheels up to which this holds, q16
_SIZE = const(3)  # 1/256 degree
_WAY = const(4)
_PER_WAY = const(5)
_SWING = const(6)  # first word of (1 - cos) / 2, 1/16384
_BELIEVED = const(264)  # _LOW or _HIGH, or neither
_MARKS = const(265)  # _LOW and _HIGH at mark()
_WATCHED = const(267)  # beside_q8 at watch()
_TURNED = const(268)  # where the casters had turned the chair to then, from either end
_WORDS = const(270)
_CELLS = const(256)

_EITHER = const(2)
_HALF_TURN = const(11796480)
_TURN = const(23592960)
_CERTAIN_Q8 = const(384)  # so much worse the other must be to be given up
_SURE_Q8 = const(192)  # the two must differ by this to decide which is right


class Casters:
    # size_q4: what they add in all, 1/16 degree, negative against the turn. way_q4: over how much.

    def __init__(self, size_q4, way_q4):
        words = [0, way_q4 << 4, 0, size_q4 << 4, way_q4 << 4, (1 << 24) // (way_q4 << 4)]
        words += [
            int(8192 * (1.0 - math.cos(math.pi * k / _CELLS)) + 0.5) for k in range(_CELLS + 1)
        ]
        words += words[-1:] + [_EITHER]
        self._words = array.array("i", words + [0] * (_WORDS - len(words)))
        self.any = size_q4 != 0
        self.mark()

    # The wheels have turned to `angle_q16`.
    @micropython.viper
    def advance(self, angle_q16: int):
        w = ptr32(self._words)
        by = angle_q16 - w[_SEEN]
        if by >= _HALF_TURN:
            by -= _TURN
        elif by + _HALF_TURN < 0:
            by += _TURN
        by = by >> 8
        seen = w[_SEEN] + (by << 8)
        if seen >= _HALF_TURN:
            seen -= _TURN
        elif seen + _HALF_TURN < 0:
            seen += _TURN
        w[_SEEN] = seen
        k = 0
        while k < 2:
            at = w[k] + by
            if at < 0:
                at = 0
            elif at > w[_WAY]:
                at = w[_WAY]
            w[k] = at
            k += 1

    # The present position; skip() restores it.
    @micropython.viper
    def mark(self):
        w = ptr32(self._words)
        w[_MARKS] = w[_LOW]
        w[_MARKS + 1] = w[_HIGH]

    # The wheels have not turned since mark(), though the model's have, to `angle_q16`.
    @micropython.viper
    def skip(self, angle_q16: int):
        w = ptr32(self._words)
        w[_LOW] = w[_MARKS]
        w[_HIGH] = w[_MARKS + 1]
        w[_SEEN] = angle_q16

    # What they add over the next `way_q8` of the wheels, both in 1/256 degree, left positive.
    @micropython.viper
    def swing_q8(self, way_q8: int) -> int:
        w = ptr32(self._words)
        most = 0
        k = 0
        while k < 2:
            at = w[k] + way_q8
            if at < 0:
                at = 0
            elif at > w[_WAY]:
                at = w[_WAY]
            to = at * w[_PER_WAY] >> 8  # 2**24 at most
            cell = (to >> 8) + _SWING
            swung = w[cell] + ((w[cell + 1] - w[cell]) * (to & 255) >> 8)
            to = w[k] * w[_PER_WAY] >> 8
            cell = (to >> 8) + _SWING
            swung -= w[cell] + ((w[cell + 1] - w[cell]) * (to & 255) >> 8)
            swung = w[_SIZE] * swung >> 14
            if k == w[_BELIEVED]:
                return swung
            if k == 0:
                most = swung
            elif way_q8 > 0:
                if swung > most:
                    most = swung
            elif swung < most:
                most = swung
            k += 1
        return most

    # Where either end's casters have turned the chair to, 1/256 degree.
    @micropython.viper
    def _turned(self, k: int) -> int:
        w = ptr32(self._words)
        to = w[k] * w[_PER_WAY] >> 8
        cell = (to >> 8) + _SWING
        return w[_SIZE] * (w[cell] + ((w[cell + 1] - w[cell]) * (to & 255) >> 8)) >> 14

    # From here on the heading is compared; beside_q8: its deviation from the wheels' angle. The
    # position assumed until now counts as certain.
    @micropython.viper
    def watch(self, beside_q8: int):
        w = ptr32(self._words)
        believed = w[_BELIEVED]
        if believed != _EITHER:
            where = w[believed]
            w[_LOW] = where
            w[_HIGH] = where
        w[_MARKS] = w[_LOW]
        w[_MARKS + 1] = w[_HIGH]
        w[_WATCHED] = beside_q8
        w[_TURNED] = int(self._turned(_LOW))
        w[_TURNED + 1] = int(self._turned(_HIGH))

    # The heading deviates from the wheels' angle by beside_q8 now: which end explains it? Returns
    # the part since watch() that the casters do not explain.
    @micropython.viper
    def learn(self, beside_q8: int) -> int:
        w = ptr32(self._words)
        by_q8 = beside_q8 - w[_WATCHED]
        low_q8 = by_q8 - int(self._turned(_LOW)) + w[_TURNED]
        high_q8 = by_q8 - int(self._turned(_HIGH)) + w[_TURNED + 1]
        apart_q8 = low_q8 - high_q8
        if apart_q8 < _SURE_Q8 and apart_q8 + _SURE_Q8 > 0:
            if w[_LOW] != w[_HIGH]:
                w[_BELIEVED] = _EITHER
            return (low_q8 + high_q8) >> 1
        # How much worse the right's end explains it.
        worse_q8 = low_q8
        if worse_q8 < 0:
            worse_q8 = 0 - worse_q8
        if high_q8 < 0:
            worse_q8 += high_q8
        else:
            worse_q8 -= high_q8
        believed = _HIGH
        rest_q8 = high_q8
        if worse_q8 < 0:
            worse_q8 = 0 - worse_q8
            believed = _LOW
            rest_q8 = low_q8
        w[_BELIEVED] = believed
        if worse_q8 > _CERTAIN_Q8:
            other = _HIGH + _LOW - believed
            w[other] = w[believed]
            w[_TURNED + other] = w[_TURNED + believed]
        return rest_q8
