# How fast the chair may be moving in one direction: nothing measures its speed, so this is an upper
# bound from the outputs it was given. Pure: integers only, no clock, no allocation.
#
# The chair is taken as a dead time, a ramp and a first-order lag. The bound rises at once to what
# an output can cause; it falls only after the dead time, with the brake, and lags behind that ramp.

from gazelink.const import const
from gazelink.native import micropython

_SHIFT = const(6)  # speeds are kept in 1/64 units/s
_SCALE = const(64)


class SpeedBound:
    # `update` is called every `period_ms`.

    def __init__(self, period_ms):
        self._period_ms = period_ms
        self._peak = 0  # highest that an output of the last dead time asked for
        self._since = 0  # highest asked for since the peak was last renewed
        self._left_ms = 0  # until the peak is over
        self._ramp = 0
        self._bound = 0

    # One period; `permille` is the highest output of it in this direction, 0..1000, `stopping` a
    # Stopping. Returns the bound, units/s rounded up. 64 * 2400 units/s * 1000 stays in 31 bits.
    @micropython.native
    def update(self, stopping, permille):
        bound = self._bound
        if permille == 0 and bound == 0:
            return 0
        asked = (permille * stopping.full * _SCALE + 999) // 1000
        if asked >= self._peak:
            self._peak = asked
            self._since = 0
            self._left_ms = stopping.dead_ms
        else:
            if asked > self._since:
                self._since = asked
            self._left_ms -= self._period_ms
            if self._left_ms < 0:
                self._peak = self._since
                self._since = asked
                self._left_ms = stopping.dead_ms
        peak = self._peak
        ramp = self._ramp
        # The lag first, behind the ramp as it was: both fall within the period.
        if bound > ramp:
            period_ms = self._period_ms
            fall = (bound - ramp) * period_ms // (stopping.tail_ms + period_ms)
            bound -= fall if fall else 1
        if ramp > peak:
            ramp = max(peak, ramp - stopping.brake * _SCALE * self._period_ms // 1000)
        elif ramp < peak:
            ramp = peak
        self._ramp = ramp
        self._bound = max(bound, ramp)
        return (self._bound + _SCALE - 1) >> _SHIFT
