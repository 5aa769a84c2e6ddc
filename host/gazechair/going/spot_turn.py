"""A turn on the spot by the stick alone: full output, let go in time, small pulses for the rest.

The chair's model (dead time, ramps, lag, breakaway) says how far it runs on when the stick is let
go; what a pulse really made of what was promised corrects the next.
"""

from __future__ import annotations

import math

from gazechair.going.chair_numbers import AxisModel

_STANDS_DEG_S = 0.8
_STANDS_TICKS = 5
_PULSES = 16  # ticks of the longest pulse
_MOVES = 6  # with corrections
_GAIN = (0.5, 1.8)
_NEAR_ENOUGH_DEG = 4.0


class SpotTurn:
    """One turn after another; `step` each period."""

    def __init__(self, model: AxisModel, output: int, period_s: float) -> None:
        self._model = model
        self._output = output
        self._period_s = period_s
        self._gain = 1.0
        self.start()

    def start(self) -> None:
        """Another target."""
        self._moves = 0
        self._left = 0  # ticks of the present pulse
        self._runs = False
        self._still = 0
        self._sign = 1.0
        self._promised: tuple[float, float] | None = None

    def step(self, heading_rad: float, target_rad: float, within_rad: float) -> int | None:
        """Permille for the next period; None: it stands at the target, as near as it gets."""
        error = math.degrees(math.remainder(target_rad - heading_rad, 2.0 * math.pi))
        if self._left:
            self._left -= 1
            return int(self._sign * self._output)
        if self._runs:
            ways = [
                self._gain * self._model.runs(self._sign * self._output, n * self._period_s)
                for n in (0, 1)
            ]
            if self._sign * (error - 0.5 * (ways[0] + ways[1])) > 0.0:
                return int(self._sign * self._output)
            self._runs = False
            return 0
        self._still = self._still + 1 if abs(self._model.speed) < _STANDS_DEG_S else 0
        if self._still < _STANDS_TICKS and self._moves:
            return 0
        self._learn(heading_rad)
        if abs(error) <= math.degrees(within_rad):
            return None
        if self._moves >= _MOVES:
            if abs(error) < _NEAR_ENOUGH_DEG:
                return None
            self._moves = 0  # the board let nothing out
        return self._move(error, heading_rad)

    def _learn(self, heading_rad: float) -> None:
        if self._promised is None:
            return
        before, promised = self._promised
        self._promised = None
        turned = math.degrees(math.remainder(heading_rad - before, 2.0 * math.pi))
        share = min(max(turned / promised, 0.3), 2.0)
        self._gain = min(max(self._gain * (1.0 + 0.5 * (share - 1.0)), _GAIN[0]), _GAIN[1])

    def _move(self, error: float, heading_rad: float) -> int | None:
        self._sign = math.copysign(1.0, error)
        self._still = 0
        ways = [
            (abs(error - self._gain * self._model.runs(self._sign * self._output, n * 0.05)), n)
            for n in range(_PULSES)
        ]
        best = min(ways)[1]
        if best == 0:
            return None if abs(error) < _NEAR_ENOUGH_DEG else 0
        self._moves += 1
        if best == _PULSES - 1:
            self._runs = True
            return int(self._sign * self._output)
        promised = self._gain * self._model.runs(self._sign * self._output, best * self._period_s)
        self._promised = (heading_rad, promised)
        self._left = best - 1
        return int(self._sign * self._output)
