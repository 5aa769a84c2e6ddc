# The caretaker's bypass: permits creep past an obstacle while the button is pressed.
#
# It lasts BYPASS_MAX_MS at most. A pause follows, whatever the host sends: a new press number gives
# no more time. Pure: integers only, no clock, no allocation.

from gazeboard.core import limits
from gazeboard.core.safety import ahead
from gazelink.const import const
from gazelink.native import micropython

_EARLY_MS = const(32)  # turns of obstacles: until each direction has taken notice


class Bypass:
    def __init__(self):
        self._number = 0  # the newest press, 0: none yet
        self._count = 0
        self._session_count = 0
        self._ttl_ms = 0
        self._used_ms = 0  # of this bypass
        self._pause_ms = 0  # before the next
        self.left_ms = 0  # of this bypass; 0: none

    # `i` is an Inputs; elapsed_ms since the last call. A press only counts when its first word
    # comes while armed and not in the pause. One that ended, by whatever, never comes back: only a
    # number ahead of it does, or one of a new session. A number ahead while a bypass lasts goes on
    # with what is left of it.
    @micropython.native
    def step(self, i, armed, elapsed_ms):
        if i.session_count != self._session_count:
            self._session_count = i.session_count
            self._number = 0
            self._ttl_ms = 0
        if self.left_ms > 0:
            self.left_ms = max(0, self.left_ms - elapsed_ms)
            self._ttl_ms -= elapsed_ms
            self._used_ms += elapsed_ms
            if self.left_ms == 0:
                self._end()
        elif self._pause_ms > 0:
            self._pause_ms -= elapsed_ms
        if i.bypass_count != self._count:
            self._count = i.bypass_count
            self._heard(i.bypass_number, i.bypass_ttl_ms)
        if self._ttl_ms <= 0 or not armed:
            self._end()

    @micropython.native
    def _end(self):
        self.left_ms = 0
        if self._used_ms:
            self._pause_ms = max(limits.BYPASS_PAUSE_MS, self._used_ms >> 1)
            self._used_ms = 0

    @micropython.native
    def _heard(self, number, ttl_ms):
        if number != self._number:
            if number == 0 or not ahead(number, self._number):
                return
            self._number = number
            if self.left_ms == 0 and self._pause_ms <= 0:
                self.left_ms = limits.BYPASS_MAX_MS - _EARLY_MS
        self._ttl_ms = min(ttl_ms, limits.COMMAND_TTL_MS) - _EARLY_MS
