"""What odometry tells: the chair's pose and speed, and how sure it is of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray


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
    turned_by_walls: bool = False
    """Whether a wall that several lidars see tells which one it is."""
    left_out: bool = False
    """Whether its piece counts for nothing: the lidar is turned against another."""

    def pose(self) -> FloatArray:
        """(3,): x, y in metres, heading in radians, full turns counted."""
        return np.array((self.x_m, self.y_m, math.radians(self.heading_deg)))

    def left_out_at(self, time_s: float, turned_deg: float, yaw_rate_deg_s: float) -> Estimate:
        """The estimate of a piece that is left out, a moment later: as the chair moved then."""
        dt_s, angle = time_s - self.time_s, math.radians(self.heading_deg + 0.5 * turned_deg)
        ahead_m, aside_m = self.speed_m_s * dt_s, self.sideways_m_s * dt_s
        return replace(
            self,
            time_s=time_s,
            x_m=self.x_m + math.cos(angle) * ahead_m - math.sin(angle) * aside_m,
            y_m=self.y_m + math.sin(angle) * ahead_m + math.cos(angle) * aside_m,
            heading_deg=self.heading_deg + turned_deg,
            yaw_rate_deg_s=yaw_rate_deg_s,
            left_out=True,
        )
