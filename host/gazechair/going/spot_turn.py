"""Turns on the spot: full output, release in time to coast to the target, short pulses at the end.

The chair's model (dead time, ramps, lag, breakaway) predicts the coast after release, and the turn
by a pulse. For a chair that breaks loose sooner or later than its model, a shift of the pulses'
length is learned from each pulse.
"""

from __future__ import annotations

import math

from gazechair.going.chair_numbers import AxisModel

_STANDS_DEG_S = 0.8
_STANDS_TICKS = 5
_PULSES = 16  # ticks of the longest pulse
_MOVES = 7  # with corrections
_GAIN = (0.5, 1.8)
_SHIFT = (-4.0, 12.0)  # ticks; above 0: it breaks loose sooner
_LEARNS = 0.7
_TELLS_DEG = 0.6  # nothing is learned from smaller turns
_NEAR_ENOUGH_DEG = 2.5


class SpotTurn:
    """Makes one turn at a time; call `start` for each target, `step` in each period."""

    def __init__(self, model: AxisModel, output: int, period_s: float) -> None:
        self._model = model
        self._output = self._let = output
        self._period_s = period_s
        self._gain = 1.0
        """Measured coast divided by the model's."""
        self._shift = 0.0
        self._answer = 0  # ticks until what was put out shows in the speed
        self.start()

    def start(self) -> None:
        """Begin a turn to another target."""
        self._moves = 0
        self._left = 0  # ticks of the present pulse
        self._done = 0  # of them, put out
        self._runs = False
        self._still = 0
        self._sign = 1.0
        self._pulsed_from: float | None = None
        self._coasts: tuple[float, float] | None = None

    @property
    def pulses(self) -> bool:
        """Whether it turns by a pulse from rest now."""
        return self._pulsed_from is not None

    def let_out(self, permille: int) -> None:
        """What the board has put out in the last period."""
        if permille:
            self._let = abs(permille)
            self._done += 1
            self._answer = round(self._model.answers_s / self._period_s)

    def step(self, heading_rad: float, target_rad: float, within_rad: float) -> int | None:
        """Permille for the next period; None: at rest, as near to the target as it gets."""
        error = math.degrees(math.remainder(target_rad - heading_rad, 2.0 * math.pi))
        if self._left:
            self._left -= 1
            return int(self._sign * self._output)
        if self._runs:
            signed = self._sign * self._let
            ways = [self._gain * self._model.runs(signed, n * self._period_s) for n in (0, 1)]
            if self._sign * (error - 0.5 * (ways[0] + ways[1])) > 0.0:
                return int(self._sign * self._output)
            self._runs = False
            self._coasts = (heading_rad, ways[0])
            return 0
        self._answer = max(0, self._answer - 1)
        stands = not self._answer and abs(self._model.speed) < _STANDS_DEG_S
        self._still = self._still + 1 if stands else 0
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
        if self._coasts is not None:
            before, promised = self._coasts
            self._coasts = None
            if abs(promised) > _TELLS_DEG:
                share = min(max(_turned_deg(before, heading_rad) / promised, 0.3), 2.0)
                gain = self._gain * (1.0 + 0.5 * (share - 1.0))
                self._gain = min(max(gain, _GAIN[0]), _GAIN[1])
        if self._pulsed_from is not None and self._done:
            turned = self._sign * _turned_deg(self._pulsed_from, heading_rad)
            ways = self._pulses()
            if max(turned, _at(ways, self._done + self._shift)) > _TELLS_DEG:
                off = _when(ways, turned) - (self._done + self._shift)
                self._shift = min(max(self._shift + _LEARNS * off, _SHIFT[0]), _SHIFT[1])
        self._pulsed_from = None

    def _pulses(self) -> list[float]:
        """Degrees that the model turns from rest by pulses of 0, 1, 2, ... ticks."""
        return [
            abs(self._model.from_rest(self._sign * self._let, n * self._period_s))
            for n in range(_PULSES + int(_SHIFT[1]) + 1)
        ]

    def _move(self, error: float, heading_rad: float) -> int | None:
        self._sign = math.copysign(1.0, error)
        self._still = self._done = 0
        ways = self._pulses()
        # Of pulses with the same effect, as those too short to turn anything, the longest.
        off = [(abs(abs(error) - _at(ways, n + self._shift)), -n) for n in range(1, _PULSES)]
        best = -min(off)[1]
        if _at(ways, best + self._shift) > 2.0 * abs(error) and abs(error) < _NEAR_ENOUGH_DEG:
            return None  # even the best pulse would overshoot
        self._moves += 1
        if best == _PULSES - 1:
            self._runs = True
            return int(self._sign * self._output)
        self._pulsed_from = heading_rad
        self._left = best - 1
        return int(self._sign * self._output)


def _turned_deg(before_rad: float, after_rad: float) -> float:
    return math.degrees(math.remainder(after_rad - before_rad, 2.0 * math.pi))


def _at(ways: list[float], ticks: float) -> float:
    """Degrees turned by a pulse of `ticks`, interpolated."""
    low = min(max(ticks, 0.0), len(ways) - 1.001)
    n = int(low)
    return ways[n] + (low - n) * (ways[n + 1] - ways[n])


def _when(ways: list[float], deg: float) -> float:
    """Ticks of the pulse that turns by `deg`, interpolated."""
    n = next((n for n, way in enumerate(ways) if way >= deg), len(ways) - 1)
    if n == 0 or ways[n] <= ways[n - 1]:
        return float(n)
    return n - min(1.0, (ways[n] - deg) / (ways[n] - ways[n - 1]))
