"""Floor points as fractions of the camera's picture, for the pages to draw over it."""

from __future__ import annotations

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.base.polyline import evenly
from gazechair.base.poses import from_frame
from gazechair.picture.floor import FloorCamera

_MOST_POINTS = 24
_STEP_M = 0.08


def over_picture(camera: FloorCamera, line_m: FloatArray, pose: FloatArray) -> list[list[float]]:
    """The visible part of a polyline (N, 2) that is in the frame of the chair's `pose`."""
    if len(line_m) < 2:
        return []
    points = from_frame(evenly(line_m, _STEP_M), pose)
    points = points[(points[:, 0] > 0.0) & camera.sees(points)]
    if len(points) > _MOST_POINTS:
        points = points[np.linspace(0, len(points) - 1, _MOST_POINTS).round().astype(int)]
    return _shares(camera, points)


def spot_over_picture(
    camera: FloorCamera, spot_m: FloatArray, pose: FloatArray
) -> list[float] | None:
    """A spot (2,) that is in the frame of the chair's `pose`; None: not in the picture."""
    point = from_frame(spot_m[None], pose)
    return _shares(camera, point)[0] if camera.sees(point)[0] else None


def _shares(camera: FloorCamera, points: FloatArray) -> list[list[float]]:
    shares = camera.pixels(points) / (camera.width_px, camera.height_px)
    return [[round(float(u), 3), round(float(v), 3)] for u, v in shares]
