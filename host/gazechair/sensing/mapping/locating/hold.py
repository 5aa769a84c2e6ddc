"""Keeps the pose near odometry's where a look alone does not determine it: people distort a fit.

A fit may deviate from odometry by fixed amounts, plus shares of the distance and the turn since the
pose was last sure; beyond that it is in doubt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.poses import between

_SIGMAS = np.array((0.005, 0.005, math.radians(0.1)))
_SHARES = 0.01, 0.003  # m a m, rad a rad
_M, _SHARE = 0.03, 0.03
_RAD, _TURN_SHARE = math.radians(0.7), 0.01


@dataclass
class Hold:
    """The pose that was last sure, and odometry's distance and turn since."""

    pose: FloatArray
    odometry: FloatArray
    driven_m: float = 0.0
    turned_rad: float = 0.0

    def move(self, before: FloatArray, odometry: FloatArray) -> None:
        """Add a motion of odometry."""
        moved = between(before, odometry)
        self.driven_m += math.hypot(moved[0], moved[1])
        self.turned_rad += abs(float(moved[2]))

    @property
    def deviations(self) -> FloatArray:
        """(3,): standard deviations (m, m, rad) of the pose that odometry gives."""
        along, about = _SHARES
        more = np.array((self.driven_m * along, self.driven_m * along, self.turned_rad * about))
        return np.asarray(_SIGMAS + more)

    def holds(self, guess: FloatArray, pose: FloatArray) -> bool:
        """Whether a fit at `pose` is compatible with odometry's `guess`."""
        off = between(guess, pose)
        near = math.hypot(off[0], off[1]) <= _M + _SHARE * self.driven_m
        return near and abs(off[2]) <= _RAD + _TURN_SHARE * self.turned_rad
