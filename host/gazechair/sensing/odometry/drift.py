"""Uncertainty of the pose since the beginning: the remembered surfaces drift with the chair.

While nobody knows how a lidar sits, its whole way may be turned.
"""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.odometry.doubts import is_corridor
from gazechair.sensing.odometry.match import ERROR, OFFSET, Fit

_M2_PER_M = 0.006**2
# Each piece of a wall is remembered by those before it: up to 0.4 degrees in 35 m of bare corridor.
_RAD2_PER_M = math.radians(0.07) ** 2
_STRAYS = 0.35  # of the way, by a turned lidar: it may seem to stand
_MATCHED_M2 = 0.02**2  # of a position that surfaces determine; beyond, it is drift already


class Drift:
    """Feed it every fit."""

    def __init__(self) -> None:
        self._covariance = np.zeros((2, 2))
        self._heading_rad2 = 0.0
        self._bumped = False
        self._stray_m = 0.0
        self._aside: FloatArray = np.zeros(2)  # deviation by a lidar that may be turned

    def grow(self, found: Fit, state: FloatArray, covariance: FloatArray) -> None:
        """Grow with the distance, and where undetermined; arguments: the fit, those before it."""
        way_m = math.hypot(*(found.state[:2] - state[:2]))
        self._covariance += np.eye(2) * _M2_PER_M * way_m
        self._heading_rad2 += _RAD2_PER_M * way_m
        if is_corridor(found.information):
            values, axes = np.linalg.eigh(found.covariance[:2, :2] - covariance[:2, :2])
            self._covariance += (axes * np.maximum(values, 0.0)) @ axes.T

    def with_match(self, covariance: FloatArray) -> FloatArray:
        """(2, 2): the position's, with its covariance relative to the remembered surfaces."""
        values, axes = np.linalg.eigh(covariance)
        return np.asarray(
            self._covariance + self._by_mounting + (axes * np.minimum(values, _MATCHED_M2)) @ axes.T
        )

    @property
    def _by_mounting(self) -> FloatArray:
        return np.outer(self._aside, self._aside) + np.eye(2) * self._stray_m**2

    def turn(self, moved_m: FloatArray, sigma_rad: float) -> None:
        """A lidar, of a direction known so well, has moved by (2,) metres."""
        self._aside = self._aside + sigma_rad * np.array((-moved_m[1], moved_m[0]))

    def stray(self, way_m: float) -> None:
        """A turned lidar has moved, or was told to: surfaces seen before it was turned mislead."""
        self._stray_m += _STRAYS * way_m

    def bump(self, lidar_m: float, sigma_rad: float) -> None:
        """A lidar that far from the axle may have been turned: the pose may have followed it."""
        self._bumped = True
        self._covariance += np.eye(2) * (lidar_m * sigma_rad) ** 2

    def heading_rad(self, covariance: FloatArray, mounting_rad: float) -> float:
        """Standard deviation of the heading since the beginning.

        `covariance`: of the state, relative to the remembered surfaces; `mounting_rad`: standard
        deviation of the lidars' directions.
        """
        parts = [OFFSET, ERROR]  # the heading is the sensor's and these
        variance = self._heading_rad2 + float(covariance[np.ix_(parts, parts)].sum())
        return math.hypot(math.sqrt(variance), mounting_rad if self._bumped else 0.0)

    def settle(self, share: float) -> None:
        """The lidars' directions are known; until now they were that share of the deviation off."""
        self._covariance += share**2 * self._by_mounting
        self._aside, self._stray_m = np.zeros(2), 0.0
