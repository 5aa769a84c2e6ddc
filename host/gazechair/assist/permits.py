"""What the board will permit where both axes move: its rule, as far as the host knows it.

The board alone decides (gazeboard/core/arcs.py). What it would end is not asked for: that would end
the driver's press.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Sequence

import numpy as np

from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.zone import UNKNOWN, StopZone
from gazelink import arcs, codes
from gazelink.zone import CREEP, FULL

_PAST_S = 0.7  # what was put out so long ago may still move the chair
_FADES_S = 1.0  # after that, what the board still counts of it fades
_AHEAD_S = 0.35  # until the next decisions have an effect
_MORE_M, _MORE_DEG = 0.05, 2.0
_AGAIN_M, _AGAIN_DEG = 0.06, 3.0  # more than creep takes, once stopped: the board's bands
_BLIND = 1 << codes.DIR_FORWARD | 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT
_UNSEEN_ARCS = 0x50  # of arc_views: forward and left, forward and right
_ROLLS_PERMILLE = 60
_HELD_PERMILLE = 150  # holding the heading puts out so much, and is no turn


class Permits:
    """Feed it every output and every clearance."""

    def __init__(self) -> None:
        self.zone: StopZone = UNKNOWN
        self._outputs: deque[tuple[float, int, int]] = deque()
        self._clearance: Clearance | None = None
        self.shut_s = -math.inf
        """When the board last would not have let a chair that it had stopped go on."""

    @property
    def clearance(self) -> Clearance | None:
        """The newest that the board was sent."""
        return self._clearance

    @clearance.setter
    def clearance(self, clearance: Clearance | None) -> None:
        self._clearance = clearance
        one = self.zone.of(codes.DIR_FORWARD)
        if clearance is None or one is None:
            return
        if self.forward_m < float(one.told[CREEP]) + _AGAIN_M:
            self.shut_s = clearance.acquired_s

    def output(self, time_s: float, linear_permille: int, turn_permille: int) -> None:
        """What the board puts out."""
        self._outputs.append((time_s, linear_permille, turn_permille))
        while self._outputs[0][0] < time_s - _PAST_S - _FADES_S:
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
        return max((linear for _, linear, _ in self._lately), default=0)

    @property
    def linear_now(self) -> int:
        """What is put out forward."""
        return max(0, self._outputs[-1][1]) if self._outputs else 0

    @property
    def turned(self) -> bool:
        """A turn was put out lately."""
        return any(abs(turn) > _HELD_PERMILLE for _, _, turn in self._lately)

    @property
    def _lately(self) -> Iterator[tuple[float, int, int]]:
        since_s = self._outputs[-1][0] - _PAST_S if self._outputs else 0.0
        return (one for one in self._outputs if one[0] >= since_s)

    def may_turn(self, side: int) -> bool:
        """Whether a turn of a chair that stands may begin, `side` 1 left, -1 right."""
        one = self.zone.of(codes.DIR_LEFT if side > 0 else codes.DIR_RIGHT)
        if one is None:
            return False
        return self.turns_deg[0 if side > 0 else 1] >= float(one.told[CREEP]) + _AGAIN_DEG

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
        left, right = self._most_turns(turn_permille)
        if turn_permille and not self.on_the_spot(turn_permille):
            return False
        linear = max(linear_permille, self.linear_permille)
        _, stop_m = self._stopping(codes.DIR_FORWARD, linear)
        stop_deg = 0.0
        for direction, most in ((codes.DIR_LEFT, left), (codes.DIR_RIGHT, right)):
            if most:
                stop_deg = max(stop_deg, self._stopping(direction, most)[1])
        # The side that is asked for counts, however little.
        rows: list[tuple[int, Sequence[int]]] = []
        if turn_permille > 0 or left > right:
            rows.append((0, arcs.TURNS_DEG))
        if turn_permille < 0 or left <= right:
            rows.append((2 * arcs.ROWS, arcs.TURNS_DEG))
        if min(left, right) > _ROLLS_PERMILLE:
            rows = [(arcs.BOTH_AT, arcs.BOTH_TURNS_DEG)]
        return all(self._way_m(at, deg, stop_deg) >= stop_m + _MORE_M for at, deg in rows)

    def _most_turns(self, asked: int) -> tuple[float, float]:
        # To the left and to the right: asked for, put out lately, and what is left of older turns.
        turns: list[float] = [asked]
        newest_s = self._outputs[-1][0] if self._outputs else 0.0
        for time_s, _, turn in self._outputs:
            left_over = min(1.0, 1.0 - (newest_s - time_s - _PAST_S) / _FADES_S)
            if asked or abs(turn) * left_over > _HELD_PERMILLE:
                turns.append(turn * max(0.0, left_over))
        return max(0.0, *turns), max(0.0, *(-turn for turn in turns))

    def _way_m(self, at: int, turns_deg: Sequence[int], stop_deg: float) -> float:
        # How far it may travel while it turns so much.
        assert self.clearance is not None
        row = next((k for k, deg in enumerate(turns_deg) if deg >= stop_deg), None)
        return -1.0 if row is None else self.clearance.arcs[at + row] * arcs.UNIT_MM / 1000.0

    def _stopping(self, direction: int, permille: float) -> tuple[float, float]:
        one = self.zone.of(direction)
        assert one is not None
        speed = float(one.speeds[FULL]) * abs(permille) / 1000.0
        return speed, float(np.interp(speed, one.speeds, one.stops)) + speed * _AHEAD_S
