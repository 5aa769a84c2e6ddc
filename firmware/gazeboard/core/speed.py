# Upper bound of the chair's speed in one direction, from the outputs; no sensor measures it.
# Pure: integers only, no clock, no allocation.
#
# The model is a dead time, a ramp and a first-order lag. The bound rises at once to what
# an output can cause; it falls only after the dead time, with the brake, and lags behind that ramp.

from array import array

from gazelink.const import const
from gazelink.native import micropython, ptr32

_SHIFT = const(6)  # speeds are kept in 1/64 units/s
_SCALE = const(64)
# Indices of the words:
_PEAK = const(0)  # highest that an output of the last dead time asked for
_SINCE = const(1)  # highest asked for since the peak was last renewed
_LEFT_MS = const(2)  # until the peak is over
_RAMP = const(3)
_BOUND = const(4)
_PERIOD_MS = const(5)
_WORDS = const(6)


class SpeedBound:
    # `update` is called every `period_ms`.

    def __init__(self, period_ms):
        self._words = array("i", [0] * _WORDS)
        self._words[_PERIOD_MS] = period_ms

    # One period; `permille` is the highest output of it in this direction, 0..1000, `stopping` a
    # Stopping. Returns the bound, units/s rounded up. 64 * 2400 units/s * 1000 stays in 31 bits.
    @micropython.viper
    def update(self, stopping, permille: int) -> int:
        w = ptr32(self._words)
        bound = w[_BOUND]
        if permille == 0 and bound == 0:
            return 0
        period_ms = w[_PERIOD_MS]
        asked = (permille * int(stopping.full) * _SCALE + 999) // 1000
        if asked >= w[_PEAK]:
            w[_PEAK] = asked
            w[_SINCE] = 0
            w[_LEFT_MS] = int(stopping.dead_ms)
        else:
            if asked > w[_SINCE]:
                w[_SINCE] = asked
            w[_LEFT_MS] -= period_ms
            if w[_LEFT_MS] < 0:
                w[_PEAK] = w[_SINCE]
                w[_SINCE] = asked
                w[_LEFT_MS] = int(stopping.dead_ms)
        peak = w[_PEAK]
        ramp = w[_RAMP]
        # The lag first, behind the ramp as it was: both fall within the period.
        if bound > ramp:
            fall = (bound - ramp) * period_ms // (int(stopping.tail_ms) + period_ms)
            if fall == 0:
                fall = 1
            bound -= fall
        if ramp > peak:
            ramp -= int(stopping.brake) * _SCALE * period_ms // 1000
        if ramp < peak:
            ramp = peak
        w[_RAMP] = ramp
        if bound < ramp:
            bound = ramp
        w[_BOUND] = bound
        return (bound + _SCALE - 1) >> _SHIFT
