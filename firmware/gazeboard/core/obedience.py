# Obedience: compares the measured turn rate with the rate that the outputs permit (P21).
#
# Pure: a step per heading sample, no allocation, integers only. Only the turn has a sensor. With a
# stuck wiper, relay or joystick interface the chair continues to turn at neutral, or turns against
# the command. Other causes (casters, a slope, a bump, a person's spasm) are slow, short, or change
# direction.

from array import array

from gazeboard.core import limits
from gazelink.const import const
from gazelink.native import micropython, ptr32
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row

_SAMPLE_MS = const(10)
_AFTER_TICKS = const(5)  # the ticks of a new sample and after it have enough to do
_FULL_PERMILLE = const(1000)
# Indices of the words:
_LEFT_Q4 = const(0)  # the most it may be turning, 1/16 degree/s
_RIGHT_Q4 = const(1)
_LEFT_HOLD_MS = const(2)  # until that falls
_RIGHT_HOLD_MS = const(3)
_REST_MS = const(4)  # nothing put out in either axis
_WRONG_MS = const(5)
_SIGN = const(6)
_FULL_Q4 = const(7)
_FALL_Q4 = const(8)
_COUNT = const(9)  # of heading samples, and what is left of the wait after one
_WAIT = const(10)
_WORDS = const(11)
_WIPER_BAD = const(2)
_WIPER_GOOD = const(3)


class Obedience:
    # settings: a Settings; configure() again whenever they change.

    def __init__(self, settings):
        self._words = array("i", [0] * _WORDS)
        self.wiper_debt = 0
        self.configure(settings)

    # Not in the tick. Any profile may be selected with the chair's own knob; a fresh battery and an
    # even floor may add a quarter to its rate.
    def configure(self, settings):
        fastest = 0
        for profile in range(len(PROFILES)):
            for name in ("left_q4_dps", "right_q4_dps"):
                row = profile_row(profile, name)
                fastest = max(fastest, getattr(settings, row), TABLE[index_of(row)][1])
        self._full_q4 = fastest * 5 // 4
        self._words[_FULL_Q4] = self._full_q4
        self._words[_FALL_Q4] = self._full_q4 * _SAMPLE_MS // limits.OBEY_FALL_MS

    # After the motion's tick; `i` is an Inputs, the outputs are those of this tick. True: the chair
    # does not obey.
    @micropython.viper
    def step(self, i, linear_permille: int, turn_permille: int, armed: int) -> bool:
        w = ptr32(self._words)
        if w[_WAIT] == 0:
            count = int(i.heading_count)
            if count != w[_COUNT]:
                w[_COUNT] = count
                w[_WAIT] = _AFTER_TICKS
            return False
        w[_WAIT] -= 1
        if w[_WAIT]:
            return False
        if armed:
            return int(self._judge(i, linear_permille, turn_permille)) != 0
        # Nothing reaches the chair: it is turned by hand.
        w[_LEFT_Q4] = 0
        w[_RIGHT_Q4] = 0
        w[_REST_MS] = 0
        w[_WRONG_MS] = 0
        return False

    # One sample. First the rate that each side permits: that of the output, and for a while that of
    # earlier outputs. Then whether the chair turns faster, and for too long.
    @micropython.viper
    def _judge(self, i, linear_permille: int, turn_permille: int) -> int:
        w = ptr32(self._words)
        # To the right rounded down, without dividing a negative number.
        asked_q4 = turn_permille * w[_FULL_Q4]
        if asked_q4 < 0:
            asked_q4 = 0 - (_FULL_PERMILLE - 1 - asked_q4) // _FULL_PERMILLE
        else:
            asked_q4 = asked_q4 // _FULL_PERMILLE
        side = 0
        while side < 2:
            if asked_q4 > 0 and asked_q4 >= w[side]:
                w[side] = asked_q4
                w[side + _LEFT_HOLD_MS] = int(limits.OBEY_HOLD_MS)
            elif w[side + _LEFT_HOLD_MS] > 0:
                w[side + _LEFT_HOLD_MS] -= _SAMPLE_MS
            else:
                most_q4 = w[side] - w[_FALL_Q4]
                if most_q4 < asked_q4:
                    most_q4 = asked_q4
                if most_q4 < 0:
                    most_q4 = 0
                w[side] = most_q4
            asked_q4 = 0 - asked_q4
            side += 1
        if linear_permille or turn_permille:
            w[_REST_MS] = 0
        elif w[_REST_MS] < int(limits.OBEY_COAST_MS):
            w[_REST_MS] += _SAMPLE_MS
        if int(i.heading_faults):
            w[_WRONG_MS] = 0
            return 0
        rate_q4 = int(i.rate_q4)
        sign = 1
        most_q4 = w[_LEFT_Q4]
        if rate_q4 < 0:
            sign = -1
            rate_q4 = 0 - rate_q4
            most_q4 = w[_RIGHT_Q4]
        if w[_REST_MS] >= int(limits.OBEY_COAST_MS):
            most_q4 += int(limits.OBEY_STANDING_Q4_DPS)
        else:
            most_q4 += int(limits.OBEY_MOVING_Q4_DPS)
        if rate_q4 <= most_q4:
            w[_WRONG_MS] = 0
            return 0
        if sign != w[_SIGN]:
            w[_SIGN] = sign
            w[_WRONG_MS] = 0
        w[_WRONG_MS] += _SAMPLE_MS
        if w[_WRONG_MS] < int(limits.OBEY_MS):
            return 0
        w[_WRONG_MS] = 0
        return 1

    # After each write that was not verified, and while there is a debt. True: for a second two of
    # three writes have failed, though never three in a row.
    @micropython.native
    def wipers_written(self, verified):
        if verified:
            self.wiper_debt = max(0, self.wiper_debt - _WIPER_GOOD)
            return False
        self.wiper_debt += _WIPER_BAD
        if self.wiper_debt < limits.WIPER_DEBT:
            return False
        self.wiper_debt = 0
        return True
