# The AD5282 as a joystick: writes both wipers and reads them back, every tick. No allocation.
#
# AD5282 data sheet rev. E: instruction byte bit 7 selects RDAC2, bits 4 and 3 drive O2 and O1 and
# are carried by every write (unused here: always 0). A read returns the RDAC last selected by a
# write.

from gazeboard.limits import WIPER_MAX, WIPER_MIN, WIPER_NEUTRAL, WIPER_SPAN
from gazelink.native import micropython

ADDRESS = 0x2C
_RDAC1 = 0x00  # linear
_RDAC2 = 0x80  # turn


@micropython.native
def counts(permille, neutral):
    # Wiper count of a deflection of -1000..1000, never outside the chair's window.
    if permille >= 0:
        value = neutral + permille * WIPER_SPAN // 1000
    else:
        value = neutral - -permille * WIPER_SPAN // 1000
    return max(WIPER_MIN, min(WIPER_MAX, value))


class Joystick:
    def __init__(self, i2c):
        self._i2c = i2c
        self._out = bytearray(2)
        self._in = bytearray(1)
        self.set_neutral(WIPER_NEUTRAL, WIPER_NEUTRAL)

    # The stored centre of both channels; only while disarmed.
    @micropython.native
    def set_neutral(self, linear_count, turn_count):
        self._neutral_linear = linear_count
        self._neutral_turn = turn_count
        self.linear_wiper = linear_count
        self.turn_wiper = turn_count
        self.neutral = True  # what was last asked for was neutral on both

    # Write both and read both back; True: verified. A bus error or a wrong value is False at once,
    # so that a stuck bus costs one time-out a tick, not four.
    @micropython.native
    def write(self, linear_permille, turn_permille):
        linear = self._neutral_linear
        turn = self._neutral_turn
        self.neutral = linear_permille == 0 and turn_permille == 0
        if not self.neutral:
            linear = counts(linear_permille, linear)
            turn = counts(turn_permille, turn)
        self.linear_wiper = linear
        self.turn_wiper = turn
        i2c = self._i2c
        out = self._out
        back = self._in
        try:
            out[0] = _RDAC1
            out[1] = linear
            i2c.writeto(ADDRESS, out)
            i2c.readfrom_into(ADDRESS, back)
            if back[0] != linear:
                return False
            out[0] = _RDAC2
            out[1] = turn
            i2c.writeto(ADDRESS, out)
            i2c.readfrom_into(ADDRESS, back)
            return back[0] == turn
        except OSError:
            return False
