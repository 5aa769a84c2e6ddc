# Does the chair do as it is told? The gyro says how it turns; this says how fast it may, from what
# was put out. Pure: a step per heading sample, no allocation, integers only.
#
# Only the turn has a sensor. A wiper, a relay or a joystick interface that got stuck turns the
# chair on although neutral is put out, or against the command. What turns it otherwise (casters, a
# slope, a bump, a person's spasm) is slow, or short, or goes to and fro.

from gazeboard.core import limits
from gazelink.const import const
from gazelink.native import micropython
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row

_SAMPLE_MS = const(10)
_AFTER_TICKS = const(5)  # the ticks of a new sample and after it have enough to do
_FULL_PERMILLE = const(1000)
_WIPER_BAD = const(2)
_WIPER_GOOD = const(3)


class Obedience:
    # settings: a Settings; configure() again whenever they change.

    def __init__(self, settings):
        self._count = 0
        self._wait = 0
        self._left_q4 = 0  # the most it may be turning, 1/16 degree/s
        self._right_q4 = 0
        self._left_hold_ms = 0  # until that falls
        self._right_hold_ms = 0
        self._rest_ms = 0  # nothing put out in either axis
        self._wrong_ms = 0
        self._sign = 0
        self.wiper_debt = 0
        self.configure(settings)

    # Not in the tick. Any profile may be selected on the chair's own knob; a quarter above its rate
    # for a fresh battery and an even floor.
    def configure(self, settings):
        fastest = 0
        for profile in range(len(PROFILES)):
            for name in ("left_q4_dps", "right_q4_dps"):
                row = profile_row(profile, name)
                fastest = max(fastest, getattr(settings, row), TABLE[index_of(row)][1])
        self._full_q4 = fastest * 5 // 4
        self._fall_q4 = self._full_q4 * _SAMPLE_MS // limits.OBEY_FALL_MS

    # After the motion's tick; `i` is an Inputs, the outputs are those of this tick. True: it
    # disobeys.
    @micropython.native
    def step(self, i, linear_permille, turn_permille, armed):
        if self._wait == 0:
            if i.heading_count != self._count:
                self._count = i.heading_count
                self._wait = _AFTER_TICKS
            return False
        self._wait -= 1
        if self._wait:
            return False
        if not armed:
            # Nothing reaches the chair: whoever turns it does so by hand.
            self._left_q4 = 0
            self._right_q4 = 0
            self._rest_ms = 0
            self._wrong_ms = 0
            return False
        self._allow(turn_permille)
        if linear_permille or turn_permille:
            self._rest_ms = 0
        elif self._rest_ms < limits.OBEY_COAST_MS:
            self._rest_ms += _SAMPLE_MS
        if i.heading_faults:
            self._wrong_ms = 0
            return False
        return self._judge(i.rate_q4)

    # How fast the chair may be turning in each sense: as the output asks for, and for a while as
    # one before did.
    @micropython.native
    def _allow(self, turn_permille):
        asked_q4 = turn_permille * self._full_q4 // _FULL_PERMILLE
        if asked_q4 > 0 and asked_q4 >= self._left_q4:
            self._left_q4 = asked_q4
            self._left_hold_ms = limits.OBEY_HOLD_MS
        elif self._left_hold_ms > 0:
            self._left_hold_ms -= _SAMPLE_MS
        else:
            self._left_q4 = max(0, asked_q4, self._left_q4 - self._fall_q4)
        asked_q4 = -asked_q4
        if asked_q4 > 0 and asked_q4 >= self._right_q4:
            self._right_q4 = asked_q4
            self._right_hold_ms = limits.OBEY_HOLD_MS
        elif self._right_hold_ms > 0:
            self._right_hold_ms -= _SAMPLE_MS
        else:
            self._right_q4 = max(0, asked_q4, self._right_q4 - self._fall_q4)

    @micropython.native
    def _judge(self, rate_q4):
        sign = 1
        most_q4 = self._left_q4
        if rate_q4 < 0:
            sign = -1
            rate_q4 = -rate_q4
            most_q4 = self._right_q4
        if self._rest_ms >= limits.OBEY_COAST_MS:
            most_q4 += limits.OBEY_STANDING_Q4_DPS
        else:
            most_q4 += limits.OBEY_MOVING_Q4_DPS
        if rate_q4 <= most_q4:
            self._wrong_ms = 0
            return False
        if sign != self._sign:
            self._sign = sign
            self._wrong_ms = 0
        self._wrong_ms += _SAMPLE_MS
        if self._wrong_ms < limits.OBEY_MS:
            return False
        self._wrong_ms = 0
        return True

    # After each write that was not verified, and while there is a debt. True: two writes of three
    # have failed for a second, though never three in a row.
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
