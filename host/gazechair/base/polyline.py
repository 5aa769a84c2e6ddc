"""Polylines: points (N, 2) in metres."""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import FloatArray


def along_m(points: FloatArray) -> FloatArray:
    """The length of the polyline up to each of its points."""
    return np.concatenate(((0.0,), np.cumsum(np.hypot(*np.diff(points, axis=0).T))))


def evenly(points: FloatArray, step_m: float) -> FloatArray:
    """The same polyline with evenly spaced points, about `step_m` apart."""
    along = along_m(points)
    at = np.linspace(0.0, along[-1], max(2, round(float(along[-1]) / step_m) + 1))
    return np.column_stack([np.interp(at, along, points[:, k]) for k in (0, 1)])
