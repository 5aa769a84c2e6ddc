"""How far what is remembered is smeared along a direction that was open.

There the position follows the command, and so do the places of surfaces that are seen meanwhile:
the same door is remembered at several places, and the corners between them are slanted. Such
surfaces once told a chair that drove 0.8 m/s that it stood. What was seen lately is not smeared.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.odometry.apart import LEAST, Constraints
from gazechair.sensing.odometry.match import ERROR, FORWARD, Fit

_SMEARED_M = 0.1  # so far, by the uncertainty of the speed
# Who just sees another heading than the sensor may have a lidar that was bumped: only what is
# remembered shows that.
_BUMPED_DEG, _BUMPED_S = 0.2, 0.5


class Smear:
    """Feed it every fit."""

    def __init__(self) -> None:
        self._at_s: float | None = None
        self._smeared_m = 0.0
        self._along: FloatArray = np.zeros(2)
        self._error_deg = 0.0  # the largest, lately

    def take(self, at_s: float, found: Fit, turn: list[Constraints]) -> bool:
        """Whether to forget what is remembered, as something in it tells the place along it.

        `turn`: what the newest turn tells.
        """
        dt_s = 0.0 if self._at_s is None else at_s - self._at_s
        self._at_s = at_s
        error_deg = abs(math.degrees(found.state[ERROR]))
        self._error_deg = max(error_deg, self._error_deg * math.exp(-dt_s / _BUMPED_S))
        if found.open_axes and not found.sees_speed:
            self._along = found.open_axes[0]
            self._smeared_m += math.sqrt(found.covariance[FORWARD, FORWARD]) * dt_s
        if self._smeared_m < _SMEARED_M or self._error_deg > _BUMPED_DEG:
            return False
        information = sum(float(one.strength @ (one.rows @ self._along) ** 2) for one in turn)
        if information < LEAST:
            return False
        self._smeared_m = 0.0
        return True
