# What the obstacles permit: per direction blocked or free, and the most output each may have. Pure:
# one tick of 1 ms, no I/O, no clock, no allocation, integers only. Only ever reduces.

from gazelink import codes
from gazelink.native import micropython

_ALL_BLOCKED = 15
_FULL_PERMILLE = 1000
_DECISIONS = bytes(  # blocked bits -> 2-bit fields
    [sum([codes.BLOCKED << (2 * d) for d in range(4) if b & (1 << d)]) for b in range(16)]
)


class Obstacles:
    # settings: a Settings.

    def __init__(self, settings):
        self._settings = settings
        self.blocked = _ALL_BLOCKED  # bits per direction
        self.decisions = _DECISIONS[_ALL_BLOCKED]  # 2 bits per direction
        self.caps = [_FULL_PERMILLE] * 4  # most output per direction, permille

    # `i` is an Inputs: the newest clearance. linear_permille, turn_permille: what was put out in
    # the tick before.
    @micropython.native
    def step(self, i, linear_permille, turn_permille):
        self.blocked = i.clearance_blocked & _ALL_BLOCKED
        self.decisions = _DECISIONS[self.blocked]
