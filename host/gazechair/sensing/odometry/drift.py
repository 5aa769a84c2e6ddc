"""Covariance of the position since the beginning: the remembered surfaces drift with the chair."""

from __future__ import annotations

import math

import numpy as np

from gazechair.base.footprint import FloatArray
from gazechair.sensing.odometry.doubts import is_corridor
from gazechair.sensing.odometry.match import Fit

_M2_PER_M = 0.006**2
_MATCHED_M2 = 0.02**2  # of a position that surfaces determine; beyond, it is drift already


class Drift:
    """Feed it every fit."""

    def __init__(self) -> None:
        self._covariance = np.zeros((2, 2))

    def grow(self, found: Fit, state: FloatArray, covariance: FloatArray) -> None:
        """Grow with the distance, and where undetermined; arguments: the fit, those before it."""
        way_m = math.hypot(*(found.state[:2] - state[:2]))
        self._covariance += np.eye(2) * _M2_PER_M * way_m
        if is_corridor(found.information):
            values, axes = np.linalg.eigh(found.covariance[:2, :2] - covariance[:2, :2])
            self._covariance += (axes * np.maximum(values, 0.0)) @ axes.T

    def with_match(self, covariance: FloatArray) -> FloatArray:
        """(2, 2): the position's, with its covariance relative to the remembered surfaces."""
        values, axes = np.linalg.eigh(covariance)
        return np.asarray(self._covariance + (axes * np.minimum(values, _MATCHED_M2)) @ axes.T)
