"""Maps pixels of the calibrated camera to floor spots in the chair's frame, and back.

A pinhole with square pixels, its axis through the picture's centre, and one radial term. Chair's
frame: metres, x forward, y left, z up from the floor under the drive axle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import BoolArray, FloatArray

# Reasons, keys of the string tables.
OUTSIDE, ABOVE_HORIZON, TOO_FAR, TOO_UNSURE = (
    "look_outside",
    "look_above_horizon",
    "look_too_far",
    "look_too_unsure",
)

FARTHEST_M = 5.0
"""Distance from the drive axle: beyond, neither gaze nor the lidars are precise enough."""
UNSURE_M = 0.5
"""A spot with a larger standard deviation is refused."""
_SAME_SHAPE = 0.01  # of the aspect ratio: a picture with another one is from another camera
_UNDISTORT_STEPS = 12
_STEP_PX = 0.5
_EYE_M = 0.6  # from the picture to the driver's eyes


@dataclass(frozen=True)
class Spot:
    """A spot on the floor. `covariance_m2`: (2, 2)."""

    x_m: float
    y_m: float
    covariance_m2: FloatArray

    @property
    def sigma_m(self) -> float:
        """Standard deviation in the worst direction."""
        return math.sqrt(float(np.linalg.eigvalsh(self.covariance_m2)[-1]))


@dataclass(frozen=True)
class NoSpot:
    """No spot; `reason` is a key of the string tables."""

    reason: str


@dataclass(frozen=True)
class FloorCamera:
    """Lens and pose. Pitch is positive downwards, yaw to the left, roll clockwise."""

    width_px: int
    height_px: int
    focal_px: float
    height_m: float
    pitch_rad: float
    yaw_rad: float = 0.0
    roll_rad: float = 0.0
    x_m: float = 0.0
    y_m: float = 0.0
    radial: float = 0.0
    """Fraction by which a ray at 45 degrees lies farther out than with a pinhole."""

    def scaled(self, width_px: int) -> FloorCamera:
        """The same camera for a picture scaled to this width."""
        share = width_px / self.width_px
        height_px = round(self.height_px * share)
        return replace(self, width_px=width_px, height_px=height_px, focal_px=self.focal_px * share)

    def same_shape(self, size_px: tuple[int, int]) -> bool:
        """True if a picture of this width and height may be from this camera."""
        return abs(size_px[0] / size_px[1] / (self.width_px / self.height_px) - 1.0) <= _SAME_SHAPE

    def floor_m(self, pixels: FloatArray) -> FloatArray:
        """(N, 2) floor points of (N, 2) pixels; nan at and above the horizon."""
        rays = self._undistorted((pixels - self._centre) / self.focal_px)
        right, down, forward = self._axes()
        directions = forward + rays[:, :1] * right + rays[:, 1:] * down
        with np.errstate(divide="ignore", invalid="ignore"):
            far = np.where(directions[:, 2] < -1e-6, -self.height_m / directions[:, 2], np.nan)
            return np.asarray(directions[:, :2] * far[:, None] + (self.x_m, self.y_m))

    def pixels(self, points_m: FloatArray) -> FloatArray:
        """(N, 2) pixels of (N, 2) floor points; nan for points behind the camera."""
        rays = self._rays(points_m)
        radius2 = (rays**2).sum(axis=1, keepdims=True)
        return np.asarray(self._centre + self.focal_px * rays * (1.0 + self.radial * radius2))

    def sees(self, points_m: FloatArray) -> BoolArray:
        """Which floor points are within the picture."""
        radius2 = (self._rays(points_m) ** 2).sum(axis=1)
        seen = self._within(self.pixels(points_m))
        # Exclude the region where the radial term folds the picture back.
        return np.asarray(seen & (1.0 + 3.0 * self.radial * radius2 > 0.05))

    def spot(
        self,
        pixel: tuple[float, float],
        sigma_px: float,
        calibration_m: float = 0.0,
    ) -> Spot | NoSpot:
        """The floor spot at `pixel`.

        `sigma_px`: of the gaze on the picture, each axis (see `gaze_px`). `calibration_m`: the
        calibration's standard deviation 2 m ahead; it grows with the square of the distance.
        """
        at = np.array((pixel,), dtype=np.float64)
        if not self._within(at)[0]:
            return NoSpot(OUTSIDE)
        found = self.floor_m(at)[0]
        if not np.isfinite(found).all():
            return NoSpot(ABOVE_HORIZON)
        away_m = math.hypot(*found)
        if away_m > FARTHEST_M:
            return NoSpot(TOO_FAR)
        slope = self._metres_per_pixel(at[0])
        worse = calibration_m * max(1.0, away_m / 2.0) ** 2
        covariance = sigma_px**2 * slope @ slope.T + worse**2 * np.eye(2)
        spot = Spot(float(found[0]), float(found[1]), covariance)
        return spot if spot.sigma_m <= UNSURE_M else NoSpot(TOO_UNSURE)

    @property
    def _centre(self) -> FloatArray:
        return np.array((0.5 * self.width_px, 0.5 * self.height_px))

    def _within(self, pixels: FloatArray) -> BoolArray:
        inside = (pixels >= 0.0) & (pixels <= (self.width_px, self.height_px))
        return np.asarray(inside.all(axis=1))

    def _rays(self, points_m: FloatArray) -> FloatArray:
        """(N, 2): right and down per metre forward."""
        right, down, forward = self._axes()
        towards = np.column_stack(
            (points_m - (self.x_m, self.y_m), np.full(len(points_m), -self.height_m))
        )
        depth = towards @ forward
        with np.errstate(divide="ignore", invalid="ignore"):
            depth = np.where(depth > 0.02, depth, np.nan)
            return np.column_stack((towards @ right, towards @ down)) / depth[:, None]

    def _axes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Right, down and forward of the picture, as directions in the chair's frame."""
        cp, sp = math.cos(self.pitch_rad), math.sin(self.pitch_rad)
        cy, sy = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        cr, sr = math.cos(self.roll_rad), math.sin(self.roll_rad)
        beside = np.array((sy, -cy, 0.0))
        below = np.array((-sp * cy, -sp * sy, -cp))
        forward = np.array((cp * cy, cp * sy, -sp))
        return cr * beside + sr * below, cr * below - sr * beside, forward

    def _undistorted(self, seen: FloatArray) -> FloatArray:
        rays = seen
        if self.radial:
            for _ in range(_UNDISTORT_STEPS):
                radius2 = (rays**2).sum(axis=1, keepdims=True)
                rays = seen / np.maximum(1.0 + self.radial * radius2, 0.2)
        return rays

    def _metres_per_pixel(self, pixel: FloatArray) -> FloatArray:
        """(2, 2): change of the floor point, m, per pixel along each axis."""
        # One-sided, downwards: just below the horizon there is no floor on the other side.
        steps = np.array(((0.0, 0.0), (_STEP_PX, 0.0), (0.0, _STEP_PX)))
        at = self.floor_m(pixel + steps)
        return np.asarray((at[1:] - at[0]).T / _STEP_PX)


def gaze_px(degrees: float, picture_width_px: int, picture_width_m: float) -> float:
    """`degrees` of gaze in pixels, for a picture `picture_width_m` wide before the driver."""
    return _EYE_M * math.radians(degrees) * picture_width_px / picture_width_m
