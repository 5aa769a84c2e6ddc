# Auto: a motion that nobody holds. Whether its press may begin and go on (P18, P20).
#
# Pure: one tick of 1 ms, integers only, no clock, no allocation. The planner's life is the
# command's (ages.py, P17); what its motion may not enter, and how fast it is, obstacles.py (P19).

from gazeboard.core import ages, limits
from gazelink import codes
from gazelink.const import const
from gazelink.native import micropython

# Numbers of other files once more, as in obstacles.py; tests/firmware/test_obstacle_numbers.py.
_PRESSES = const(27)
_SUPERVISED = const(32)
_OVERRULED_MS = const(10000)
_NO_REASON = const(0)


class Auto:
    # words: those of Ages. Without settings nothing is permitted.

    def __init__(self, words):
        self._words = words
        self._limit_ms = 0
        self.left_ms = 0  # of the press that moves the chair
        self.overruled_ms = 0  # by an obstacle, since it last moved

    # settings: a Settings. Only while disarmed.
    def configure(self, settings):
        self._limit_ms = 1000 * settings.auto_limit_s
        self._words[ages.SUPERVISION_MOST] = settings.supervision_ms - limits.MARGIN_MS

    # A tick of the press: why it ends, or does not begin. running: it moves the chair already.
    # `i` is an Inputs; missed_ms passed without a tick before this one.
    @micropython.native
    def why_not(self, i, running, missed_ms):
        words = self._words
        if words[_PRESSES] != (0 if running else 1):
            return codes.ANOTHER_PRESS
        if words[_SUPERVISED] == 0 or i.supervision_edge != i.edge:
            return codes.SUPERVISION_LOST
        left_ms = self.left_ms
        if not running:
            if i.verb != codes.DRIVE:
                return codes.BAD_COMMAND
            left_ms = self._limit_ms
            self.overruled_ms = 0
        elif self.overruled_ms >= _OVERRULED_MS:
            return codes.AUTO_OVERRULED
        left_ms -= 1 + missed_ms
        self.left_ms = left_ms
        return codes.AUTO_LIMIT if left_ms <= 0 else _NO_REASON

    # It is permitted again: but standing by itself says nothing about the obstacle.
    @micropython.native
    def permitted(self, i):
        if i.linear_permille or i.turn_permille:
            self.overruled_ms = 0

    # A tick in which it is not, for `reason`. True: the press waits, as for a person who walks by.
    @micropython.native
    def waits(self, reason, missed_ms):
        if reason != codes.ABOVE_CREEP and (
            reason < codes.OBSTACLE_FORWARD or reason > codes.OBSTACLE_RIGHT
        ):
            return False
        self.overruled_ms += 1 + missed_ms
        return True
