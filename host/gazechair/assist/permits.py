"""Predicts what the board permits when both axes move: the host's copy of the board's rule.

The board alone decides (gazeboard/core/arcs.py). Assist requests nothing that the board would end,
because that ends the driver's press.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from gazechair.board.board_commands import Clearance
from gazechair.sensing.clearance.standing import Approach
from gazechair.sensing.clearance.zone import UNKNOWN, Stopping, StopZone
from gazelink import arcs, codes
from gazelink.settings_table import TABLE, index_of
from gazelink.zone import CREEP, FULL

_LATELY_S = 0.7
_AHEAD_S = 0.35  # until the next decisions take effect
_MORE_M, _MORE_DEG = 0.05, 2.0
_AGAIN_M, _AGAIN_DEG = 0.06, 3.0  # beyond creep's clearance, to go on after a stop: BAND_*
_OPENS_S = 0.35  # a closed direction reopens after this long, latency included
_BLIND = 1 << codes.DIR_FORWARD | 1 << codes.DIR_LEFT | 1 << codes.DIR_RIGHT
_UNSEEN_ARCS = 0x50  # bits of arc_views: forward and left, forward and right
_ROLLS_M_S, _TURNS_DEG_S = 0.02, 1.0  # slower counts as standing; but see _Side.holding
# An output up to this may hold the heading: it is no turn.
_HOLDING_PERMILLE: int = TABLE[index_of("hold_permille")][1]
# Shares of the stopping time without braking: the board's dead time and lag.
_DEAD, _LAG = 0.3, 0.9
_LATE_S = 0.15  # age of a clearance when the board uses it


class _Side:
    """One direction as the board judges it, in m or degrees: possible speed, and whether open."""

    def __init__(self) -> None:
        self.stopping: Stopping | None = None
        self.bound = 0.0
        """The highest speed that its outputs may have caused, as the board calculates it."""
        self.open = True
        self._ramp = 0.0
        self._better_s: float | None = None
        self._requested: deque[tuple[float, float]] = deque()
        self._last_s = -math.inf

    def output(self, time_s: float, permille: int) -> None:
        if self.stopping is None:
            return
        requested = float(self.stopping.speeds[FULL]) * max(0, permille) / 1000.0
        whole_s = float(self.stopping.times_s[0])
        brake = float(self.stopping.speeds[FULL]) / (float(self.stopping.times_s[FULL]) - whole_s)
        dt_s, self._last_s = max(0.0, min(0.2, time_s - self._last_s)), time_s
        self._requested.append((time_s, requested))
        while self._requested[0][0] < time_s - _DEAD * whole_s:
            self._requested.popleft()
        self.bound -= max(0.0, self.bound - self._ramp) * dt_s / (_LAG * whole_s + dt_s)
        peak = max(one for _, one in self._requested)
        self._ramp = max(peak, self._ramp - brake * dt_s)
        self.bound = max(self.bound, self._ramp)

    def free(self, clearance: float, band: float, at_s: float) -> None:
        """A new clearance. Closes at once, opens after a while of `band` more than creep needs."""
        if self.stopping is None:
            return
        least = float(self.stopping.permits_at[CREEP])
        if clearance < least:
            self.open = False
        if clearance < least + band:
            self._better_s = None
        elif self._better_s is None:
            self._better_s = at_s
        elif at_s - self._better_s >= _OPENS_S:
            self.open = True

    @property
    def holding(self) -> float:
        """The speed that holding the heading may cause."""
        assert self.stopping is not None
        return float(self.stopping.speeds[FULL]) * _HOLDING_PERMILLE / 1000.0

    def stop(self, permille: float) -> float:
        """Distance or angle until it stands, counted from when the next decisions take effect."""
        assert self.stopping is not None
        speed = max(self.bound, float(self.stopping.speeds[FULL]) * abs(permille) / 1000.0)
        return float(np.interp(speed, self.stopping.speeds, self.stopping.stops)) + speed * _AHEAD_S


class Permits:
    """Feed it the board's zone, every output and every clearance."""

    def __init__(self) -> None:
        self._zone = UNKNOWN
        self._forward, self._left, self._right = _Side(), _Side(), _Side()
        self._outputs: deque[tuple[float, int, int]] = deque()
        self._clearance: Clearance | None = None
        self._approach = Approach(None)
        self.shut_s = -math.inf
        """When the clearance ahead was last too short for a stopped chair to go on."""

    @property
    def zone(self) -> StopZone:
        """The board's stopping distances and times."""
        return self._zone

    @zone.setter
    def zone(self, zone: StopZone) -> None:
        self._zone = zone
        self._approach = Approach(zone.of(codes.DIR_FORWARD))
        self._forward.stopping = zone.of(codes.DIR_FORWARD)
        self._left.stopping = zone.of(codes.DIR_LEFT)
        self._right.stopping = zone.of(codes.DIR_RIGHT)

    @property
    def clearance(self) -> Clearance | None:
        """The newest clearance that was sent to the board."""
        return self._clearance

    @clearance.setter
    def clearance(self, clearance: Clearance | None) -> None:
        self._clearance = clearance
        one = self._forward.stopping
        if clearance is None or one is None:
            return
        if self.forward_m < float(one.permits_at[CREEP]) + _AGAIN_M:
            self.shut_s = clearance.acquired_s
        for side, deg in zip((self._left, self._right), self.turns_deg, strict=True):
            side.free(deg, _AGAIN_DEG, clearance.acquired_s)

    def output(self, time_s: float, linear_permille: int, turn_permille: int) -> None:
        """A new output of the board."""
        self._outputs.append((time_s, linear_permille, turn_permille))
        while self._outputs[0][0] < time_s - _LATELY_S:
            self._outputs.popleft()
        self._forward.output(time_s, linear_permille)
        self._left.output(time_s, turn_permille)
        self._right.output(time_s, -turn_permille)

    @property
    def turns_deg(self) -> tuple[float, float]:
        """Clearance of a turn on the spot, left and right; 0 while unknown."""
        clearance = self.clearance
        if clearance is None:
            return 0.0, 0.0
        return clearance.left_q4_deg / 16.0, clearance.right_q4_deg / 16.0

    @property
    def forward_m(self) -> float:
        """Clearance straight ahead; 0 while unknown."""
        return 0.0 if self.clearance is None else self.clearance.forward_mm / 1000.0

    @property
    def seen(self) -> bool:
        """True if no lidar is blind where forward or a turn would lead."""
        clearance = self.clearance
        return clearance is not None and not (clearance.blocked & _BLIND or clearance.arc_views & 5)

    @property
    def linear_permille(self) -> int:
        """The highest forward output of the last 0.7 s."""
        return max((linear for _, linear, _ in self._outputs), default=0)

    @property
    def linear_now(self) -> int:
        """The present forward output, 0 when backward."""
        return max(0, self._outputs[-1][1]) if self._outputs else 0

    @property
    def rolls(self) -> bool:
        """True if the chair may still roll forward."""
        return self._forward.bound > _ROLLS_M_S

    @property
    def turned(self) -> bool:
        """True if the board put out a turn in the last 0.7 s."""
        return any(abs(turn) > _HOLDING_PERMILLE for _, _, turn in self._outputs)

    @property
    def turns_to(self) -> int:
        """The side to which the chair may be turning: 1 left, -1 right, 0 neither."""
        left, right = self._left.bound, self._right.bound
        return 0 if max(left, right) < _TURNS_DEG_S else 1 if left >= right else -1

    def surprise_permille(self, way_m: float) -> int:
        """The highest forward output that the board permits if a person appears `way_m` ahead.

        1000 where the board stops for a person at any speed.
        """
        one = self._forward.stopping
        if one is None or way_m < self._approach.blocked_within_m:
            return 1000
        stops = one.stops + one.speeds * _LATE_S
        speed = float(np.interp(self._approach.reported_m(way_m), stops, one.speeds))
        return round(1000.0 * max(speed, float(one.speeds[CREEP])) / float(one.speeds[FULL]))

    def may_turn(self, side: int) -> bool:
        """True if a standing chair may begin to turn to `side`: 1 left, -1 right."""
        one = self._left if side > 0 else self._right
        if one.stopping is None:
            return False
        free_deg = self.turns_deg[0 if side > 0 else 1]
        return one.open and free_deg >= float(one.stopping.permits_at[CREEP]) + _AGAIN_DEG

    def on_the_spot(self, turn_permille: int) -> bool:
        """True if a turn with this output may begin or continue."""
        left = turn_permille > 0
        one = self._left if left else self._right
        if one.stopping is None or not one.open:
            return False
        least_deg = max(float(one.stopping.permits_at[CREEP]), one.stop(turn_permille))
        return self.turns_deg[0 if left else 1] > least_deg + _MORE_DEG

    def both(self, linear_permille: int, turn_permille: int) -> bool:
        """True if the board permits both outputs together, or the turn while the chair still rolls.

        False where no lidar ever sees the arc: both would creep, and hardly any chair turns then.
        """
        clearance = self.clearance
        if clearance is None or self._left.stopping is None or self._right.stopping is None:
            return False
        if turn_permille and not self.on_the_spot(turn_permille):
            return False
        if not linear_permille and not self.rolls:
            return True
        if turn_permille and clearance.arc_views & _UNSEEN_ARCS:
            return False
        both = linear_permille and turn_permille
        left, right = (
            side.bound > (_TURNS_DEG_S if both else side.holding)
            for side in (self._left, self._right)
        )
        left, right = left or turn_permille > 0, right or turn_permille < 0
        if not left and not right:
            return True
        rows: tuple[int, Sequence[int]] = 0 if left else 2 * arcs.ROWS, arcs.TURNS_DEG
        if left and right:
            rows = arcs.BOTH_AT, arcs.BOTH_TURNS_DEG
        stop_m = self._forward.stop(linear_permille) + _MORE_M
        stop_deg = max(
            self._left.stop(max(0, turn_permille)) if left else 0.0,
            self._right.stop(max(0, -turn_permille)) if right else 0.0,
        )
        return self._way_m(*rows, stop_deg) >= stop_m

    def _way_m(self, at: int, turns_deg: Sequence[int], stop_deg: float) -> float:
        # How far it may travel while it turns by `stop_deg`, m; -1: it may not turn so far.
        assert self.clearance is not None
        row = next((k for k, deg in enumerate(turns_deg) if deg >= stop_deg), None)
        return -1.0 if row is None else self.clearance.arcs[at + row] * arcs.UNIT_MM / 1000.0
