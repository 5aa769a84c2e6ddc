# The AD5282 as a joystick: writes both wipers and reads them back, every tick. No allocation.
#
# AD5282 data sheet rev. E: instruction byte bit 7 selects RDAC2, bits 4 and 3 drive O2 and O1 and
# are carried by every write (unused here: always 0). A read returns the RDAC last selected by a
# write.

from gazeboard.core import limits
from gazelink.const import const
from gazelink.native import micropython, ptr8

ADDRESS = const(0x2C)
_RDAC1 = const(0x00)  # linear
_RDAC2 = const(0x80)  # turn
_NOT_KNOWN = const(1001)  # no deflection: whatever comes next is another


@micropython.viper
def counts(permille: int, neutral: int) -> int:
    # Wiper count of a deflection of -1000..1000, never outside the chair's window.
    if permille >= 0:
        value = neutral + permille * int(limits.WIPER_SPAN) // 1000
    else:
        value = neutral - (0 - permille) * int(limits.WIPER_SPAN) // 1000
    if value < int(limits.WIPER_MIN):
        value = int(limits.WIPER_MIN)
    elif value > int(limits.WIPER_MAX):
        value = int(limits.WIPER_MAX)
    return value


def permille(count, neutral):
    # The least deflection that gives this count: 0 at neutral only.
    off = count - neutral
    if off >= 0:
        return (off * 1000 + limits.WIPER_SPAN - 1) // limits.WIPER_SPAN
    return -((-off * 1000 + limits.WIPER_SPAN - 1) // limits.WIPER_SPAN)


class Joystick:
    def __init__(self, i2c):
        self._i2c = i2c
        self._linear_out = bytearray((_RDAC1, 0))
        self._turn_out = bytearray((_RDAC2, 0))
        self._bus = (i2c, self._linear_out, self._turn_out, bytearray(1))  # found at once
        self._let_go_linear = bytearray((_RDAC1, 0))
        self._let_go_turn = bytearray((_RDAC2, 0))
        self.set_neutral(limits.WIPER_NEUTRAL, limits.WIPER_NEUTRAL)

    # The stored centre of both channels; only while disarmed.
    @micropython.native
    def set_neutral(self, linear_count, turn_count):
        self.neutral_linear = linear_count
        self.neutral_turn = turn_count
        self._let_go_linear[1] = linear_count
        self._let_go_turn[1] = turn_count
        self._aim(0, 0)

    # What to write from now on.
    @micropython.viper
    def _aim(self, linear_permille: int, turn_permille: int):
        linear = int(self.neutral_linear)
        turn = int(self.neutral_turn)
        self._linear_permille = linear_permille
        self._turn_permille = turn_permille
        if linear_permille or turn_permille:
            self.neutral = False
            linear = int(counts(linear_permille, linear))
            turn = int(counts(turn_permille, turn))
        else:
            self.neutral = True  # on both
        self.linear_wiper = linear
        self.turn_wiper = turn
        out = ptr8(self._linear_out)
        out[1] = linear
        out = ptr8(self._turn_out)
        out[1] = turn

    # Write both and read both back; True: verified. A bus error or a wrong value is False at once,
    # so that a stuck bus costs one time-out a tick, not four.
    @micropython.native
    def write(self, linear_permille, turn_permille):
        if linear_permille != self._linear_permille or turn_permille != self._turn_permille:
            self._aim(linear_permille, turn_permille)
        i2c, linear_out, turn_out, back = self._bus
        try:
            i2c.writeto(ADDRESS, linear_out)
            i2c.readfrom_into(ADDRESS, back)
            if back[0] != linear_out[1]:
                return False
            i2c.writeto(ADDRESS, turn_out)
            i2c.readfrom_into(ADDRESS, back)
            return back[0] == turn_out[1]
        except OSError:
            return False

    # Neutral on both, whatever else is broken: each write independent, no read, no calculation.
    def let_go(self):
        self._linear_permille = _NOT_KNOWN
        try:
            self._i2c.writeto(ADDRESS, self._let_go_linear)
        except Exception:
            pass
        try:
            self._i2c.writeto(ADDRESS, self._let_go_turn)
        except Exception:
            pass
