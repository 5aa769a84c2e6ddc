"""Steering while driving: converts the offset from the path into the stick's turn axis.

Curves need room on both sides. Where there is little, the board lets a steered chair only creep,
or refuses the curve: there the stick points straight ahead, so that the board holds the heading.
"""

from __future__ import annotations

import math

from gazechair.going.chair_numbers import AxisModel, ChairNumbers

NARROW_M = 0.22
"""Clearance below which the chair is steered and aimed more carefully."""
STEER_MOST_RAD = math.radians(18.0)
_LOOK_M = 1.0
_CREEPS_M, _FITS_M = 0.13, 0.05  # here curves are slow; with this free ahead, none is needed
MISS_M = 0.04
_STEER_M, _STEER_RAD = 0.02, math.radians(1.0)
_CALM_M, _CALM_RAD = 0.008, math.radians(0.4)
_STEER_PER_S, _STEER_DEG_S, _STEER_NARROW_DEG_S = 0.9, 18.0, 8.0
_TIGHT_M, _UNSTEERED_S = 0.06, 2.0  # the board refuses curves: drive straight, for this long
_BEND_PER_S, _BEND_DEG_S = 1.2, 20.0
TURNS_DEG_S = 4.0
"""A slower turn is nearly over."""


class Steering:
    """Steers one chair; `begin` before each leg."""

    def __init__(self, numbers: ChairNumbers, turn: AxisModel) -> None:
        self._numbers, self._turn = numbers, turn
        self._steers = False
        self._unsteered_s = 0.0

    def begin(self) -> None:
        """Begin another leg."""
        self._steers = False

    def passed(self, seconds: float, refused: bool) -> None:
        """Account for `seconds`; `refused`: a curve was requested, and there was no output."""
        self._unsteered_s = _UNSTEERED_S if refused else self._unsteered_s - seconds

    def straight(
        self, across: float, error: float, left_m: float, room_m: float, straight_m: float
    ) -> int:
        """Turn output, permille, along a leg.

        `across`: metres left of the leg as it is driven, also backward. `error`: the chair's
        heading on it minus the present one, rad. `left_m`: what remains of it. `room_m`,
        `straight_m`: clearance along the path, and straight on.
        """
        fits = straight_m > _FITS_M and miss_m(across, error, left_m) < MISS_M
        if room_m < _TIGHT_M or self._unsteered_s > 0.0 or (room_m < _CREEPS_M and fits):
            self._steers = False
            return 0
        # Aim at the line, more steeply the farther off; do not steer within the tolerance.
        toward = math.atan2(-across, max(0.5, min(_LOOK_M, left_m)))
        toward = max(-STEER_MOST_RAD, min(STEER_MOST_RAD, 1.5 * toward))
        aim = error + toward
        off = abs(across) > _STEER_M or abs(aim) > _STEER_RAD
        calm = abs(across) < _CALM_M and abs(aim) < _CALM_RAD
        self._steers = off or (self._steers and not calm)
        if not self._steers:
            return 0
        rate = math.degrees(aim) * _STEER_PER_S
        most = _STEER_DEG_S if room_m > NARROW_M else _STEER_NARROW_DEG_S
        return self._permille(max(-most, min(most, rate)))

    def curved(self, rate_rad_s: float, across: float, error: float) -> int:
        """Turn output, permille, along a bend: its turn rate, and a correction back to it."""
        back = max(-STEER_MOST_RAD, min(STEER_MOST_RAD, math.atan2(-across, 0.5)))
        rate = math.degrees(rate_rad_s + _BEND_PER_S * (error + back))
        return self._permille(max(-_BEND_DEG_S, min(_BEND_DEG_S, rate)))

    def _permille(self, rate_deg_s: float) -> int:
        """0 against a turn that is not over: the board would have to permit both sides."""
        if rate_deg_s * self._turn.speed < 0.0 and abs(self._turn.speed) > TURNS_DEG_S:
            return 0
        return self._numbers.turn_permille(rate_deg_s)


def miss_m(across: float, error: float, left_m: float) -> float:
    """Offset from the leg after driving straight to its end, or over the next metre."""
    return abs(across - min(left_m, _LOOK_M) * math.sin(error))
