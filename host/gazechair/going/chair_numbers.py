"""The selected profile's numbers as the board stores them, in SI units, and a model of an axis."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from gazelink.settings_table import profile_row

SPOT_DEG_S = 30.0
_RAMP_M_S2 = 0.6  # of the chair's own controller, estimated
_STEP_S = 0.025  # a whole number of these per period of the follower
_KEPT_S = 0.4  # measured speeds older than this count as so old
_CORRECTS = 0.3


@dataclass(frozen=True)
class ChairNumbers:
    """What the planner and the follower know of the chair: speeds, ramps, delays, limits."""

    forward_m_s: float
    backward_m_s: float
    brake_m_s2: float
    left_deg_s: float
    right_deg_s: float
    deadband: float
    dead_s: float
    lag_s: float
    accelerate_deg_s2: float
    brake_deg_s2: float
    breakaway_deg_s: float
    linear_most: int
    """Highest output that the settings allow, permille; `turn_most` likewise."""
    turn_most: int
    cap_m_s: float
    """Highest speed at which the board lets the chair drive by itself."""

    @classmethod
    def of(cls, settings: Mapping[str, int]) -> ChairNumbers:
        """From the board's settings by name."""

        def row(name: str) -> float:
            return float(settings[profile_row(settings["profile"], name)])

        return cls(
            row("forward_mm_s") / 1000.0,
            row("backward_mm_s") / 1000.0,
            row("brake_mm_s2") / 1000.0,
            row("left_q4_dps") / 16.0,
            row("right_q4_dps") / 16.0,
            row("deadband_permille") / 1000.0,
            row("dead_time_ms") / 1000.0,
            row("lag_ms") / 1000.0,
            row("accelerate_dps2"),
            row("brake_dps2"),
            row("breakaway_q4_dps") / 16.0,
            settings["linear_permille"],
            settings["turn_permille"],
            settings["auto_mm_s"] / 1000.0,
        )

    @property
    def most_m_s(self) -> float:
        """Highest speed, m/s, at which it drives by itself; 0 if the limit is in the deadband."""
        share = (self.linear_most / 1000.0 - self.deadband) / (1.0 - self.deadband)
        return max(0.0, min(self.cap_m_s, share * self.forward_m_s))

    @property
    def most_deg_s(self) -> float:
        """Rate of a turn on the spot, degrees/s."""
        return self.turned_deg_s(self.spot_permille)

    def turned_deg_s(self, permille: int) -> float:
        """Steady turn rate, degrees/s, at an output, to the slower side."""
        share = (abs(permille) / 1000.0 - self.deadband) / (1.0 - self.deadband)
        return share * min(self.left_deg_s, self.right_deg_s)

    @property
    def spot_permille(self) -> int:
        """Output of a turn on the spot: a moderate rate that still overcomes breakaway."""
        rate = max(SPOT_DEG_S, 1.4 * self.breakaway_deg_s)
        share = min(1.0, rate / min(self.left_deg_s, self.right_deg_s))
        return min(self.turn_most, round(1000.0 * (self.deadband + share * (1.0 - self.deadband))))

    def drives_within(self, most: int) -> bool:
        """Whether outputs of `most` permille drive the chair, and turn it to one side at least."""
        _, turn = self.within(0, self.spot_permille, most)
        faster = max(self.left_deg_s, self.right_deg_s) / min(self.left_deg_s, self.right_deg_s)
        return self.rolls_within(most) and faster * self.turned_deg_s(turn) > self.breakaway_deg_s

    def rolls_within(self, most: int) -> bool:
        """Whether outputs of `most` permille drive the chair straight on."""
        return min(self.linear_most, most) / 1000.0 > self.deadband

    def moves_within(self, linear_m_s: float, rate: float, most: int) -> bool:
        """Whether outputs of `most` permille move the chair as requested: on, or on the spot."""
        on_spot = rate != 0.0 and linear_m_s == 0.0
        return self.drives_within(most) if on_spot else self.rolls_within(most)

    def linear_permille(self, speed_m_s: float) -> int:
        """Output for a speed, forward positive; 0 below 0.01 m/s."""
        full = self.forward_m_s if speed_m_s > 0.0 else self.backward_m_s
        return self._permille(speed_m_s / full, 0.01 / full, self.linear_most)

    def turn_permille(self, rate_deg_s: float) -> int:
        """Output for a turn rate, left positive; 0 below 0.2 degrees/s."""
        full = self.left_deg_s if rate_deg_s > 0.0 else self.right_deg_s
        return self._permille(rate_deg_s / full, 0.2 / full, self.turn_most)

    def _permille(self, share: float, least: float, most: int) -> int:
        if abs(share) < least:
            return 0
        size = self.deadband + min(1.0, abs(share)) * (1.0 - self.deadband)
        return int(math.copysign(min(round(1000.0 * size), most), share))

    def within(self, linear: int, turn: int, most: int) -> tuple[int, int]:
        """The same curve, slower, with neither output above `most`, permille.

        The board would limit each axis by itself, and so change the curve.
        """
        largest, deadband = max(abs(linear), abs(turn)), 1000.0 * self.deadband
        if largest <= most:
            return linear, turn
        share = max(0.0, most - deadband) / max(1.0, largest - deadband)

        def less(output: int) -> int:
            size = min(abs(output), round(deadband + share * max(0.0, abs(output) - deadband)))
            return int(math.copysign(min(size, most), output))

        return less(linear), less(turn)

    def linear_axis(self) -> AxisModel:
        """Model of the speed, m/s."""
        ramps = (_RAMP_M_S2, self.brake_m_s2)
        return AxisModel(self, self.forward_m_s, self.backward_m_s, ramps, 0.0)

    def turn_axis(self) -> AxisModel:
        """Model of the turn rate, degrees/s."""
        ramps = (self.accelerate_deg_s2, self.brake_deg_s2)
        full = (self.left_deg_s, self.right_deg_s)
        return AxisModel(self, *full, ramps, self.breakaway_deg_s)


class AxisModel:
    """Dead time, deadband, ramp, lag: predicts how an axis moves on."""

    def __init__(
        self,
        numbers: ChairNumbers,
        positive: float,
        negative: float,
        ramps: tuple[float, float],
        breakaway: float,
    ) -> None:
        self._numbers = numbers
        self._positive, self._negative = positive, negative
        self._up, self._down = ramps
        self._breakaway = breakaway
        self._follow = 1.0 - math.exp(-_STEP_S / numbers.lag_s)
        self._delay = max(1, round(numbers.dead_s / _STEP_S))
        self._pending: deque[float] = deque([0.0] * self._delay, maxlen=self._delay)
        self._ramp = 0.0
        self.speed = 0.0
        self._speeds: deque[float] = deque([0.0], maxlen=round(_KEPT_S / _STEP_S))
        """Up to now, the newest last."""

    def _asked(self, permille: float) -> float:
        deadband = self._numbers.deadband
        share = (abs(permille) / 1000.0 - deadband) / (1.0 - deadband)
        if share <= 0.0:
            return 0.0
        return share * self._positive if permille > 0.0 else -share * self._negative

    def put_out(
        self, permille: float, seconds: float, measured: float | None = None, old_s: float = 0.0
    ) -> None:
        """Advance by `seconds` at an output.

        `measured`: the speed `old_s` ago; None: not known. It corrects the model's of that time,
        and so all speeds since.
        """
        for _ in range(max(1, round(seconds / _STEP_S))):
            wanted = self._pending[0]
            self._pending.append(self._asked(permille))
            self._ramp, self.speed = self._step(self._ramp, self.speed, wanted)
            self._speeds.append(self.speed)
        if measured is None:
            return
        since = min(max(0, round(old_s / _STEP_S)), len(self._speeds) - 1)
        change = _CORRECTS * (measured - self._speeds[-1 - since])
        for n in range(-1 - since, 0):
            self._speeds[n] += change
        self.speed += change

    def _step(self, ramp: float, speed: float, wanted: float) -> tuple[float, float]:
        faster = abs(wanted) > abs(ramp) and wanted * ramp >= 0.0
        change = (self._up if faster else self._down) * _STEP_S
        ramp += max(-change, min(change, wanted - ramp))
        drive = ramp
        if abs(speed) < 0.05 * self._breakaway and abs(ramp) < self._breakaway:
            return ramp, 0.0
        return ramp, speed + (drive - speed) * self._follow

    @property
    def answers_s(self) -> float:
        """Time after which an output shows in the speed, even of a chair that it barely moves."""
        return self._numbers.dead_s + self._numbers.lag_s

    def runs(self, permille: float, seconds: float) -> float:
        """Distance (m or degrees) until rest if `permille` is put out for `seconds`, then 0."""
        return self._runs(permille, seconds, self._ramp, self.speed, list(self._pending))

    def from_rest(self, permille: float, seconds: float) -> float:
        """The same, from standstill."""
        return self._runs(permille, seconds, 0.0, 0.0, [])

    def _runs(
        self, permille: float, seconds: float, ramp: float, speed: float, pending: list[float]
    ) -> float:
        way = 0.0
        todo = [*pending, *([self._asked(permille)] * round(seconds / _STEP_S))]
        n = 0
        while n < len(todo) or (n < 200 and (abs(ramp) > 1e-6 or abs(speed) > 0.02 * self._up)):
            ramp, speed = self._step(ramp, speed, todo[n] if n < len(todo) else 0.0)
            way += speed * _STEP_S
            n += 1
        return way + speed * self._numbers.lag_s

    def dead_way(self) -> tuple[float, float]:
        """Distance (m or degrees) covered within the dead time, and the speed at its end."""
        ramp, speed, way = self._ramp, self.speed, 0.0
        for wanted in self._pending:
            ramp, speed = self._step(ramp, speed, wanted)
            way += speed * _STEP_S
        return way, speed
