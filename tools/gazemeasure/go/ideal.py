"""The ideal time of a way: the permitted speed on its legs, time-optimal turns between them.

The board's cap for auto motions permits at most 0.35 m/s of the chair's outermost point; until the
board trusts the profile, it assumes the fastest possible chair. The ideal has no ramps on the legs,
and no slower speed in narrow places.
"""

from __future__ import annotations

import math
from typing import Any

from gazeboard.core.stopping import Stopping
from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.plan import Path, Pose
from gazelink import codes


class Permitted:
    """Permitted speeds of one chair's auto motions, forward and turning on the spot."""

    def __init__(self, settings: Any, numbers: ChairNumbers, trusted: bool) -> None:
        """`settings`: the board's. `trusted`: the board trusts the selected profile."""
        self.numbers = numbers
        forward, left, right = (
            self._share(Stopping(settings, direction, trusted).auto)
            for direction in (codes.DIR_FORWARD, codes.DIR_LEFT, codes.DIR_RIGHT)
        )
        self.m_s = min(numbers.cap_m_s, forward * numbers.forward_m_s)
        self.deg_s = max(left * numbers.left_deg_s, right * numbers.right_deg_s)

    def _share(self, permille: int) -> float:
        deadband = self.numbers.deadband
        return (permille / 1000.0 - deadband) / (1.0 - deadband)


def ideal_s(path: Path, start: Pose, permitted: Permitted) -> float:
    """Seconds for the way at the permitted speed, with time-optimal turns on the spot."""
    total, before = path.length_m / permitted.m_s, start[2]
    for number, (a, b) in enumerate(zip(path.points_m[:-1], path.points_m[1:], strict=True)):
        heading = math.atan2(b[1] - a[1], b[0] - a[0])
        if path.backward and number == 0:
            heading += math.pi
        total += _turn_s(heading - before, permitted)
        before = heading
    if path.heading_rad is not None:
        total += _turn_s(path.heading_rad - before, permitted)
    return total


def _turn_s(angle_rad: float, permitted: Permitted) -> float:
    """Seconds of a turn: full deflection, full brake, dead time once, the lag as a delay."""
    angle = abs(math.degrees(math.remainder(angle_rad, 2.0 * math.pi)))
    if angle < 2.0:
        return 0.0
    numbers, most = permitted.numbers, permitted.deg_s
    up, down = numbers.accelerate_deg_s2, numbers.brake_deg_s2
    peak = min(most, math.sqrt(2.0 * angle * up * down / (up + down)))
    ramps = peak / up + peak / down
    return numbers.dead_s + numbers.lag_s + ramps + (angle - 0.5 * peak * ramps) / most
