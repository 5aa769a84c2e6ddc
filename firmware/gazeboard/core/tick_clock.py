# Checks the pace of the ticks against the microsecond clock.
#
# Ages are counted in ticks, so ticks that come too rarely would slow them down unnoticed. Pure:
# integers only.

from gazeboard.core import limits
from gazelink.native import micropython

_TICK_US = 1000
_LONG_US = 1000000  # no more is counted at once; the clock wraps far beyond


class TickClock:
    def __init__(self):
        self.late = False  # a stall, or more than 5 % too slow for a while
        self.owes = False  # a tick in time is news, too
        self.behind_us = 0  # what is not made up for by ticks in quick succession, less the 5 %
        self._owed_us = 0  # passed and not yet counted, below a millisecond

    # A tick comes elapsed_us after the one before. Returns the whole milliseconds that passed
    # without a tick since then. Ticks in quick succession afterwards do not take them back, because
    # an age that began in between does not contain them.
    @micropython.native
    def step(self, elapsed_us):
        if elapsed_us < 0 or elapsed_us > _LONG_US:
            elapsed_us = _LONG_US
        excess_us = elapsed_us - _TICK_US
        behind_us = self.behind_us + excess_us - limits.TICK_SLOW_US
        self.behind_us = max(0, min(behind_us, 2 * limits.TICK_BEHIND_US))
        self.late = elapsed_us > limits.TICK_STALLED_US or self.behind_us > limits.TICK_BEHIND_US
        owed_us = max(0, self._owed_us + excess_us)
        self._owed_us = owed_us % _TICK_US
        self.owes = self.behind_us > 0 or self._owed_us > 0
        return owed_us // _TICK_US
