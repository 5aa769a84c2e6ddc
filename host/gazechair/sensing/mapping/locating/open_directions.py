"""Directions of the position that the map leaves open: there it follows odometry, less surely."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.sensing.mapping.locating.pose_information import PoseInformation

_PLACED_M = 0.03  # deviation of a pose that is set
# How far a thing that alone tells otherwise than odometry may be off, with odometry's deviations.
_OFF_M, _OFF_SIGMAS = 0.02, 3.0


class OpenDirections:
    """Counts since the map last left no direction open."""

    def __init__(self) -> None:
        self.odometry_sigma_m = 0.0
        """Of odometry's position now, since its beginning; set it with each look."""
        self._began_sigma_m = 0.0  # of odometry then
        self._pose_sigma_m = _PLACED_M  # of the pose then
        self._followed_m: FloatArray = np.zeros(2)  # one thing, against odometry

    def none(self, sigma_m: float = _PLACED_M) -> None:
        """No direction is open; the position's standard deviation is `sigma_m`."""
        self._began_sigma_m, self._pose_sigma_m = self.odometry_sigma_m, sigma_m
        self._followed_m = np.zeros(2)

    def follow_one(self, moved_m: FloatArray) -> None:
        """Odometry has been left by `moved_m`, (2,), for what one thing alone tells."""
        self._followed_m = self._followed_m + moved_m

    def axes(self, seen: PoseInformation, off_m: FloatArray) -> FloatArray:
        """(N, 2): those that a look leaves open where odometry is `off_m`, (2,), off the fit."""
        off_one_m = np.abs(seen.by_one @ (off_m + self._followed_m))
        contradicted = off_one_m > _OFF_M + _OFF_SIGMAS * self._grown_m
        return np.concatenate((seen.open_axes, seen.by_one[contradicted]))

    @property
    def sigma_m(self) -> float:
        """Standard deviation of the position along an open direction."""
        return math.hypot(self._pose_sigma_m, self._grown_m)

    @property
    def _grown_m(self) -> float:
        return math.sqrt(max(0.0, self.odometry_sigma_m**2 - self._began_sigma_m**2))
