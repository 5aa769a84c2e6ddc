"""What odometry tells: the chair's pose and speed, and how sure it is of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gazechair.base.footprint import FloatArray


@dataclass(frozen=True)
class Estimate:
    """Where the chair is and how it moves, in a frame that begins where odometry began.

    The pose is the drive axle's; x forward at the beginning, y left, headings counter-clockwise.
    Uncertainties are standard deviations; those of the position accumulate since the beginning,
    along and across the chair.
    """

    time_s: float
    """Monotonic time of the measurements, not of the computation."""
    x_m: float
    y_m: float
    heading_deg: float
    speed_m_s: float
    sideways_m_s: float
    yaw_rate_deg_s: float
    along_sigma_m: float
    across_sigma_m: float
    heading_sigma_deg: float
    speed_sigma_m_s: float
    matched: float
    """Share of the points that lie on surfaces seen before, 0..1."""
    doubts: tuple[str, ...]
    """Keys of `doubts`."""
    track: int
    """Number of the start: positions of different tracks are unrelated."""
    mounting_sigma_deg: float = 0.0
    """Of the lidars' directions on the chair: a pose by a map may be turned as far."""
    turned_lidar: int | None = None
    """Number of the one that most likely is turned on its mount; None: none seems to be."""

    def pose(self) -> FloatArray:
        """(3,): x, y in metres, heading in radians, full turns counted."""
        return np.array((self.x_m, self.y_m, math.radians(self.heading_deg)))
