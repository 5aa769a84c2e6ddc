"""Guided calibration of the camera over the floor: from taps on the picture, by least squares.

A tap is on a mark at a place measured with a tape, or anywhere on the base of a wall whose line
the lidars see. Weak priors hold what a few taps cannot determine (lens, camera position); an
impossible set is refused with the reason and what to do.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gazechair.base.arrays import FloatArray
from gazechair.picture.floor import FloorCamera

LEAST_TAPS = 6
RESIDUAL_M = 0.06
"""Largest disagreement of taps, as a distance on the floor 2 m ahead."""
SIGMA_M = 0.05
"""Largest standard deviation of a floor spot within 2 m."""
TAP_PX = 4.0
"""Standard deviation of a finger's tap, on a picture 640 pixels wide."""
TAPE_M = 0.01
_NEAREST_M, _FARTHEST_M = 0.3, 6.0
_SPREAD_M = 0.25
_APART_M = 0.1
_HEIGHT_M = (0.3, 2.2)
_AT_M = np.array(((2.0, 0.0), (1.5, 0.6), (1.5, -0.6)))
_STEPS = 40

# Fitted, with the start's standard deviations: a camera on the chair, that looks ahead and down.
_FITTED = ("height_m", "pitch_rad", "yaw_rad", "roll_rad", "focal_px", "x_m", "y_m", "radial")
_SIGMAS = (0.4, 0.35, 0.25, 0.1, 0.25, 0.05, 0.05, 0.08)  # of the focal length: a share
_NUDGES = np.array((1e-4, 1e-4, 1e-4, 1e-4, 1e-2, 1e-4, 1e-4, 1e-4))


@dataclass(frozen=True)
class Tap:
    """A tap on a mark: pixel, and the mark's place in the chair's frame."""

    pixel: tuple[float, float]
    place_m: tuple[float, float]


@dataclass(frozen=True)
class FootTap:
    """A tap on a wall's base, between two points of the wall that the lidars see."""

    pixel: tuple[float, float]
    wall_m: tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Calibration:
    """`residual_m`: disagreement of the taps 2 m ahead; `sigma_m`: of a spot there, by the fit."""

    camera: FloorCamera
    residual_m: float
    sigma_m: float


@dataclass(frozen=True)
class Refused:
    """`reason` is a key of the string tables; `worst`: number of the tap that fits worst;
    `residual_m` as in Calibration, if it was fitted."""

    reason: str
    worst: int | None = None
    residual_m: float | None = None


FEW, SPREAD, UNITS, RESIDUAL, SWAPPED, AXES, UNSURE, OUTSIDE = (
    "floor_few_taps",
    "floor_taps_in_line",
    "floor_wrong_units",
    "floor_residual",
    "floor_left_right_swapped",
    "floor_forward_left_swapped",
    "floor_unsure",
    "floor_tap_outside",
)


def calibrate(start: FloorCamera, taps: Sequence[Tap | FootTap]) -> Calibration | Refused:
    """The camera that fits the taps; `start`: as mounted, estimated by eye and tape."""
    refused = _refused(start, taps)
    if refused is not None:
        return refused
    camera, covariance = _fit(start, taps)
    residual_m, worst = _residual_m(camera, taps)
    high = _HEIGHT_M[0] <= camera.height_m <= _HEIGHT_M[1]
    if not (high and residual_m <= RESIDUAL_M):
        reason = _mistake(start, taps) or (RESIDUAL if high else UNITS)
        return Refused(reason, worst, residual_m)
    sigma_m = _sigma_m(camera, covariance)
    if not sigma_m <= SIGMA_M:
        return Refused(UNSURE)
    return Calibration(camera, residual_m, sigma_m)


def _refused(start: FloorCamera, taps: Sequence[Tap | FootTap]) -> Refused | None:
    """What is wrong with the taps before any fit; None: nothing."""
    if len(taps) < LEAST_TAPS:
        return Refused(FEW)
    for number, tap in enumerate(taps):
        u, v = tap.pixel
        if not (0.0 <= u <= start.width_px and 0.0 <= v <= start.height_px):
            return Refused(OUTSIDE, number)
    ends = [tap.wall_m if isinstance(tap, FootTap) else (tap.place_m,) for tap in taps]
    places = np.array([end for one in ends for end in one], dtype=np.float64)
    away = np.hypot(places[:, 0], places[:, 1])
    if not np.isfinite(away).all() or np.median(away) > _FARTHEST_M or away.max() < _NEAREST_M:
        return Refused(UNITS)
    pixels = np.array([tap.pixel for tap in taps])
    # Marks in one line, one mark many times, or taps in one line of the picture define no plane.
    places = np.unique(np.round(places / _APART_M), axis=0) * _APART_M
    if _spread(places) < 0.5 * _SPREAD_M or _spread(pixels) < 0.02 * start.width_px:
        return Refused(SPREAD)
    return None


def _spread(points: FloatArray) -> float:
    """Standard deviation of the points from the best-fitting line."""
    off = points - points.mean(axis=0)
    return math.sqrt(max(0.0, float(np.linalg.eigvalsh(off.T @ off / len(off))[0])))


def _fit(start: FloorCamera, taps: Sequence[Tap | FootTap]) -> tuple[FloorCamera, FloatArray]:
    """Levenberg-Marquardt on the taps and the start; the camera and its parameters' covariance."""
    begin = _parameters(start)
    sigmas = np.array(_SIGMAS)
    sigmas[4] *= start.focal_px

    def errors(values: FloatArray) -> FloatArray:
        camera = _camera(start, values)
        seen = np.nan_to_num(_tap_errors(camera, taps), nan=50.0, posinf=50.0, neginf=-50.0)
        return np.concatenate((_tempered(seen), (values - begin) / sigmas))

    values, damping = begin, 1e-2
    now = errors(values)
    for _ in range(_STEPS):
        slope = _slope(errors, values, now)
        normal = slope.T @ slope
        step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -slope.T @ now)
        tried = errors(values + step)
        if tried @ tried < now @ now:
            done = now @ now - tried @ tried < 1e-9
            values, now, damping = values + step, tried, max(1e-7, damping / 5.0)
            if done:
                break
        else:
            damping = min(1e7, damping * 4.0)
    slope = _slope(errors, values, now)
    return _camera(start, values), np.asarray(np.linalg.inv(slope.T @ slope))


def _slope(
    errors: Callable[[FloatArray], FloatArray], at: FloatArray, now: FloatArray
) -> FloatArray:
    columns = [(errors(at + nudge) - now) / nudge.sum() for nudge in np.diag(_NUDGES)]
    return np.column_stack(columns)


def _tempered(errors: FloatArray) -> FloatArray:
    """Errors beyond 4 sigma count linearly instead of squared."""
    size = np.abs(errors)
    far = np.sqrt(np.maximum(8.0 * size - 16.0, 0.0))
    return np.where(size < 4.0, errors, np.sign(errors) * far)


def _tap_errors(camera: FloorCamera, taps: Sequence[Tap | FootTap]) -> FloatArray:
    """Errors in standard deviations: two per mark, one per wall base."""
    sigma_px = TAP_PX * camera.width_px / 640.0
    found = []
    for tap in taps:
        pixel = np.array((tap.pixel,), dtype=np.float64)
        if isinstance(tap, FootTap):
            near = pixel + sigma_px * np.array(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
            off = _off_wall_m(camera.floor_m(near), tap)
            scale = np.hypot(np.hypot(off[1] - off[0], off[2] - off[0]), TAPE_M)
            found.append(off[:1] / scale)
        else:
            place = np.array((tap.place_m,), dtype=np.float64)
            ends = place + TAPE_M * np.array(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)))
            seen = camera.pixels(ends)
            taped = np.hypot(seen[1] - seen[0], seen[2] - seen[0])
            found.append((seen[0] - pixel[0]) / np.hypot(taped, sigma_px))
    return np.concatenate(found)


def _off_wall_m(points_m: FloatArray, tap: FootTap) -> FloatArray:
    a, b = np.array(tap.wall_m, dtype=np.float64)
    along = (b - a) / np.hypot(*(b - a))
    return np.asarray((points_m - a) @ (-along[1], along[0]))


def _residual_m(camera: FloorCamera, taps: Sequence[Tap | FootTap]) -> tuple[float, int]:
    """Root mean square error of the taps, scaled to 2 m ahead; and the number of the worst."""
    offs = []
    for tap in taps:
        at = camera.floor_m(np.array((tap.pixel,), dtype=np.float64))
        if isinstance(tap, FootTap):
            off = abs(float(_off_wall_m(at, tap)[0]))
        else:
            off = float(np.hypot(*(at[0] - tap.place_m)))
        # A pixel covers more metres at a larger distance.
        away = math.hypot(*(at[0] - (camera.x_m, camera.y_m)))
        share = (camera.height_m**2 + 4.0) / (camera.height_m**2 + away**2)
        offs.append(off * min(share, 1.0) if math.isfinite(off) else math.inf)
    rms = math.sqrt(sum(off**2 for off in offs) / len(offs))
    return rms, int(np.argmax(offs))


def _sigma_m(camera: FloorCamera, covariance: FloatArray) -> float:
    """Standard deviation of floor spots within 2 m, worst direction, by the covariance."""
    begin = _parameters(camera)
    pixels = camera.pixels(_AT_M)
    now = camera.floor_m(pixels)
    moved = [_camera(camera, begin + nudge).floor_m(pixels) - now for nudge in np.diag(_NUDGES)]
    slopes = np.stack(moved, axis=2) / _NUDGES
    worst = max(float(np.linalg.eigvalsh(s @ covariance @ s.T)[-1]) for s in slopes)
    return math.sqrt(worst)


def _mistake(start: FloorCamera, taps: Sequence[Tap | FootTap]) -> str | None:
    """The usual mistake that, once undone, makes the set fit; None: none does."""
    for reason, undo in ((SWAPPED, _mirrored), (AXES, _turned)):
        undone = [_changed(tap, undo) for tap in taps]
        if _refused(start, undone) is None:
            camera, _ = _fit(start, undone)
            if _residual_m(camera, undone)[0] <= RESIDUAL_M:
                return reason
    return None


def _mirrored(place: tuple[float, float]) -> tuple[float, float]:
    return place[0], -place[1]


def _turned(place: tuple[float, float]) -> tuple[float, float]:
    return place[1], place[0]


Undo = Callable[[tuple[float, float]], tuple[float, float]]


def _changed(tap: Tap | FootTap, undo: Undo) -> Tap | FootTap:
    if isinstance(tap, FootTap):
        return FootTap(tap.pixel, (undo(tap.wall_m[0]), undo(tap.wall_m[1])))
    return Tap(tap.pixel, undo(tap.place_m))


def _parameters(camera: FloorCamera) -> FloatArray:
    return np.array([getattr(camera, name) for name in _FITTED], dtype=np.float64)


def _camera(like: FloorCamera, values: FloatArray) -> FloorCamera:
    return replace(like, **dict(zip(_FITTED, values.tolist(), strict=True)))
