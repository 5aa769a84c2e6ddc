"""What the board will permit where both axes move: its rule, as far as the host knows it.

The board alone decides (gazeboard/core/arcs.py). What it would end is not asked for: that would end
the driver's press.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazelink import arcs, codes
from gazelink.zone import FULL

_PAST_S = 0.7  # what was put out so long ago may still move the chair
_AHEAD_S = 0.35  # until the next decisions have an effect
_MORE_M, _MORE_DEG = 0.05, 2.0
_BLIND = 1 << codes.DIR_FORWARD | 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT
_UNSEEN_ARCS = 0x50  # of arc_views: forward and left, forward and right
_ROLLS_PERMILLE = 60
_HELD_PERMILLE = 150  # holding the heading puts out so much, and is no turn


class Permits:
    """Feed it every output and every clearance."""

    def __init__(self) -> None:
        self.zone: StopZone = UNKNOWN
        self._outputs: deque[tuple[float, int, int]] = deque()
        self.clearance: Clearance | None = None
        """The newest that the board was sent."""

    def output(self, time_s: float, linear_permille: int, turn_permille: int) -> None:
        """What the board puts out."""
        self._outputs.append((time_s, linear_permille, turn_permille))
        while self._outputs[0][0] < time_s - _PAST_S:
            self._outputs.popleft()

    @property
    def turns_deg(self) -> tuple[float, float]:
        """Free on the spot, left and right."""
        clearance = self.clearance
        if clearance is None:
            return 0.0, 0.0
        return clearance.left_q4_deg / 16.0, clearance.right_q4_deg / 16.0

    @property
    def forward_m(self) -> float:
        """Free straight ahead."""
        return 0.0 if self.clearance is None else self.clearance.forward_mm / 1000.0

    @property
    def seen(self) -> bool:
        """No lidar is blind where forward or a turn would lead."""
        clearance = self.clearance
        return clearance is not None and not (clearance.blocked & _BLIND or clearance.arc_views & 5)

    @property
    def linear_permille(self) -> int:
        """The most forward that was put out lately."""
        return max((linear for _, linear, _ in self._outputs), default=0)

    @property
    def linear_now(self) -> int:
        """What is put out forward."""
        return max(0, self._outputs[-1][1]) if self._outputs else 0

    @property
    def turned(self) -> bool:
        """A turn was put out lately."""
        return any(abs(turn) > _HELD_PERMILLE for _, _, turn in self._outputs)

    def on_the_spot(self, turn_permille: int) -> bool:
        """Whether a turn of so much may begin or go on."""
        if not self.zone.of(codes.DIR_LEFT):
            return False
        left = turn_permille > 0
        _, stop_deg = self._stopping(codes.DIR_LEFT if left else codes.DIR_RIGHT, turn_permille)
        return self.turns_deg[0 if left else 1] > stop_deg + _MORE_DEG

    def both(self, linear_permille: int, turn_permille: int) -> bool:
        """Whether the chair may turn so much while it drives so fast.

        Not where no lidar ever sees an arc: both would creep, and hardly any chair turns then.
        """
        clearance = self.clearance
        if clearance is None or not self.zone.of(codes.DIR_LEFT):
            return False
        if turn_permille and clearance.arc_views & _UNSEEN_ARCS:
            return False
        turns = [turn for _, _, turn in self._outputs] + [turn_permille]
        if not turn_permille:
            turns = [turn for turn in turns if abs(turn) > _HELD_PERMILLE]
        most_left = max([0, *turns])
        most_right = max([0, *(-turn for turn in turns)])
        if turn_permille and not self.on_the_spot(turn_permille):
            return False
        linear = max(linear_permille, self.linear_permille)
        _, stop_m = self._stopping(codes.DIR_FORWARD, linear)
        stop_deg = 0.0
        for direction, most in ((codes.DIR_LEFT, most_left), (codes.DIR_RIGHT, most_right)):
            if most:
                stop_deg = max(stop_deg, self._stopping(direction, most)[1])
        turns_deg: tuple[int, ...]
        if min(most_left, most_right) > _ROLLS_PERMILLE:
            at, turns_deg = arcs.BOTH_AT, tuple(arcs.BOTH_TURNS_DEG)
        else:
            left = most_left > most_right
            at, turns_deg = arcs.ROWS * (0 if left else 2), arcs.TURNS_DEG
        row = next((k for k, deg in enumerate(turns_deg) if deg >= stop_deg), None)
        if row is None:
            return False
        return int(clearance.arcs[at + row]) * arcs.UNIT_MM / 1000.0 >= stop_m + _MORE_M

    def _stopping(self, direction: int, permille: int) -> tuple[float, float]:
        one = self.zone.of(direction)
        assert one is not None
        speed = float(one.speeds[FULL]) * abs(permille) / 1000.0
        return speed, float(np.interp(speed, one.speeds, one.stops)) + speed * _AHEAD_S
