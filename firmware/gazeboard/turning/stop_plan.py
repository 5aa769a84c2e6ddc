# The fastest end of a turn, and the angle at which it ends.
#
# Full counter-deflection until the chair's ramp has reversed so far that, after release, lag and
# ramp come to rest together. Integers in the tick; the tables are made when settings change.
#
# With ramp r and rate w towards the turn's side, brake b, accelerate a, lag T:
#   the ramp is back at zero after r / b; the rate is then z = (w - r - b T) e^(-r / (b T)) + b T;
#   a counter-lobe of peak c (up with a, back with b, at most the full speed) ends at rate 0 for one
#   z only; so counter[z] holds the angle of that lobe, and in all the chair still turns
#   r^2 / (2 b) + T w - counter[z], because the lag delays the ramp's area and loses none of it.

import array
import math

from gazelink.const import const
from gazelink.native import micropython, ptr32

# Indices of the numbers.
_BRAKE_LAG = const(0)  # b T, 1/64 degree/s
_PER_BRAKE = const(1)  # 131072 / b
_LAG = const(2)  # T * 4.096, to make 1/256 degree of 1/64 degree/s
_SHIFT = const(3)  # of a rate, to its place in the tables
_DECAY = const(4)  # first word of e^(-r / (b T)), 1/16384
_COUNTER = const(40)  # first word of counter[z], 1/256 degree
_CELLS = const(34)

# Indices of a ChairModel's state.
_RAMP = const(1)
_RATE = const(2)
_ANGLE = const(4)

_HALF_TURN = const(11796480)  # q16
_TURN = const(23592960)


class StopPlan:
    # Speeds in 1/16 degree/s, ramps in degrees/s^2. ahead: full speed towards the turn's side,
    # against: in the opposite direction.

    # brakes_q8: how far its ramp turns while it returns from full speed, 1/256 degree.

    def __init__(self, ahead_q4, against_q4, accelerate, brake, lag_ms):
        self.brakes_q8 = ahead_q4 * ahead_q4 // (2 * brake)
        shift = 2
        # A quarter more than full speed has its place, on either side: the ramp comes from both.
        while (max(ahead_q4, against_q4) * 5) >> shift >= _CELLS - 2:
            shift += 1
        words = [brake * lag_ms * 64 // 1000, 131072 // brake, lag_ms * 4096 // 1000, shift]
        cell = (1 << shift) / 64  # degrees/s
        lag_s = lag_ms / 1000
        words += [int(16384 * math.exp(-k * cell / (brake * lag_s)) + 0.5) for k in range(_CELLS)]
        words += [0] * (_COUNTER - len(words))
        words += counter_areas(cell, _CELLS, against_q4 / 16, accelerate, brake, lag_s)
        self._words = array.array("i", words)

    # How far the wheels still turn towards the side, 1/256 degree, from the angle `seen_q16` on:
    # the effect of outputs within the dead time, and the rest if the turn is ended now: released,
    # or by counter-deflection. state: a ChairModel's; side: 1 left, -1 right.
    @micropython.viper
    def ahead_q8(self, state, seen_q16: int, side: int, counters: int) -> int:
        s = ptr32(state)
        w = ptr32(self._words)
        way = s[_ANGLE] - seen_q16
        if way >= _HALF_TURN:
            way -= _TURN
        elif way + _HALF_TURN < 0:
            way += _TURN
        ramp = side * (s[_RAMP] >> 10)
        rate = side * (s[_RATE] >> 4)
        # 12800^2 / 1024 * 6553 < 2**30.
        area = (ramp * ramp >> 10) * w[_PER_BRAKE] >> 12
        if ramp < 0:
            area = 0 - area
        area += side * (way >> 8) + (rate * w[_LAG] >> 10)
        if ramp <= 0 or counters == 0:
            return area
        shift = w[_SHIFT]
        mask = (1 << shift) - 1
        at = (ramp >> shift) + _DECAY
        decay = w[at] + ((w[at + 1] - w[at]) * (ramp & mask) >> shift)
        z = ((rate - ramp - w[_BRAKE_LAG]) * decay >> 14) + w[_BRAKE_LAG]
        if z <= 0:
            return area
        at = (z >> shift) + _COUNTER
        if at > _COUNTER + _CELLS - 2:
            return area - w[_COUNTER + _CELLS - 1]
        return area - w[at] - ((w[at + 1] - w[at]) * (z & mask) >> shift)

    # Counter-deflection continues: 2 while the ramp is on the turn's side, 1 while the chair would
    # not stand yet when the ramp, after release, is back at zero; then 0.
    @micropython.viper
    def counters(self, state, side: int) -> int:
        s = ptr32(state)
        w = ptr32(self._words)
        ramp = side * (s[_RAMP] >> 10)
        if ramp > 0:
            return 2
        ramp = 0 - ramp
        rate = side * (s[_RATE] >> 4)
        shift = w[_SHIFT]
        at = (ramp >> shift) + _DECAY
        decay = w[at] + ((w[at + 1] - w[at]) * (ramp & ((1 << shift) - 1)) >> shift)
        if ((rate + ramp + w[_BRAKE_LAG]) * decay >> 14) > w[_BRAKE_LAG]:
            return 1
        return 0


# Angle, 1/256 degree, of the counter-lobe that ends rate 0, cell, 2 cell, ... at ramp 0.
def counter_areas(cell, cells, full, accelerate, brake, lag_s):
    areas = [0]
    z_before = 0.0
    area_before = 0.0
    step = full / 64
    peak = 0.0
    hold_s = 0.0
    while len(areas) < cells:
        if peak < full:
            peak += step
        else:
            hold_s += 0.01
        up = math.exp(min(20.0, peak / (accelerate * lag_s)))
        back = math.exp(min(20.0, peak / (brake * lag_s)))
        held = math.exp(min(20.0, hold_s / lag_s))
        # Backwards from rest: the return, full deflection, the way up.
        z = accelerate * lag_s + (brake * lag_s * (back - 1.0) * held - accelerate * lag_s) * up
        area = peak * peak * 0.5 * (1.0 / accelerate + 1.0 / brake) + peak * hold_s
        while len(areas) < cells and z >= len(areas) * cell:
            share = (len(areas) * cell - z_before) / (z - z_before)
            areas.append(int(256 * (area_before + share * (area - area_before))))
        z_before = z
        area_before = area
    return areas
