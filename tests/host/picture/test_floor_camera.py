"""The camera over the floor: there and back, its uncertainty, calibration and its refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.picture import floor_calibration as fc
from gazechair.picture.floor import (
    ABOVE_HORIZON,
    OUTSIDE,
    TOO_FAR,
    TOO_UNSURE,
    FloorCamera,
    NoSpot,
    Spot,
    gaze_px,
)

LEVEL = FloorCamera(640, 480, 417.0, 1.15, math.radians(20.0), x_m=0.3)
SKEWED = FloorCamera(640, 480, 380.0, 1.02, 0.42, -0.08, 0.05, 0.21, -0.15, 0.06)
MARKS = [(1.2, 0.0), (1.4, 0.4), (1.4, -0.4), (2.0, 0.0), (2.0, 0.6), (2.0, -0.6), (2.8, 0.3)]
MOUNTED = FloorCamera(640, 480, 417.0, 1.1, 0.35, 0.0, 0.0, 0.22, -0.14)


def _taps(camera: FloorCamera, seed: int = 1) -> list[fc.Tap]:
    random = np.random.default_rng(seed)
    pixels = camera.pixels(np.array(MARKS)) + random.normal(0.0, 2.0, (len(MARKS), 2))
    return [fc.Tap((float(u), float(v)), m) for (u, v), m in zip(pixels, MARKS, strict=True)]


def _error_m(camera: FloorCamera, truth: FloorCamera) -> float:
    at = np.array(((1.5, 0.0), (2.0, 0.0), (2.0, 0.5), (2.0, -0.5)))
    return float(np.hypot(*(camera.floor_m(truth.pixels(at)) - at).T).max())


@pytest.mark.parametrize("camera", [LEVEL, SKEWED])
def test_there_and_back(camera: FloorCamera) -> None:
    points = np.array(((1.5, 0.0), (2.0, 0.7), (4.0, -1.0)))
    assert camera.sees(points).all()
    assert np.abs(camera.floor_m(camera.pixels(points)) - points).max() < 1e-3
    small = camera.scaled(160)
    assert np.allclose(4.0 * small.pixels(points), camera.pixels(points))


def test_a_camera_worked_out_by_hand() -> None:
    """Its centre looks at height / tan(pitch); left is left, and nearer is lower."""
    spot = LEVEL.floor_m(np.array(((320.0, 240.0), (200.0, 240.0), (320.0, 300.0))))
    assert np.allclose(spot[0], (0.3 + 1.15 / math.tan(math.radians(20.0)), 0.0))
    assert spot[1][1] > 0.5
    assert spot[2][0] < spot[0][0]


def test_a_roll_clockwise_lifts_what_is_right_of_the_picture() -> None:
    rolled = FloorCamera(640, 480, 417.0, 1.15, 0.35, roll_rad=0.1)
    upright = FloorCamera(640, 480, 417.0, 1.15, 0.35)
    right = np.array(((2.0, -0.5),))
    assert rolled.pixels(right)[0][1] < upright.pixels(right)[0][1]


@pytest.mark.parametrize(
    ("pixel", "reason"),
    [
        ((320.0, 20.0), ABOVE_HORIZON),
        ((320.0, 95.0), TOO_FAR),
        ((700.0, 300.0), OUTSIDE),
        ((-1.0, 300.0), OUTSIDE),
    ],
)
def test_a_look_that_meets_no_floor_within_reach_is_refused(
    pixel: tuple[float, float], reason: str
) -> None:
    assert LEVEL.spot(pixel, 5.0) == NoSpot(reason)


def test_uncertainty_is_what_noise_makes_of_it() -> None:
    random = np.random.default_rng(4)
    at = LEVEL.pixels(np.array(((2.2, 0.4),)))[0]
    spot = LEVEL.spot((float(at[0]), float(at[1])), 6.0)
    assert isinstance(spot, Spot)
    drawn = LEVEL.floor_m(at + random.normal(0.0, 6.0, (4000, 2)))
    assert np.allclose(np.cov(drawn.T), spot.covariance_m2, rtol=0.15, atol=2e-4)
    worse = LEVEL.spot((float(at[0]), float(at[1])), 6.0, calibration_m=0.1)
    assert isinstance(worse, Spot)
    assert worse.sigma_m > spot.sigma_m
    assert LEVEL.spot((320.0, 200.0), 40.0) == NoSpot(TOO_UNSURE)


def test_a_degree_of_gaze_is_more_than_a_degree_of_the_camera() -> None:
    assert gaze_px(1.0, 640, 0.29) == pytest.approx(23.1, abs=0.1)


@pytest.mark.parametrize("seed", range(6))
def test_taps_on_marks_find_the_camera(seed: int) -> None:
    found = fc.calibrate(MOUNTED, _taps(SKEWED, seed))
    assert isinstance(found, fc.Calibration)
    assert _error_m(found.camera, SKEWED) < 0.05
    assert found.residual_m < 0.03
    assert found.sigma_m < 0.05


def test_taps_on_the_feet_of_walls_find_the_camera() -> None:
    walls = [((2.5, -1.5), (2.5, 1.5)), ((1.0, 0.8), (2.5, 0.8)), ((1.4, -0.7), (2.4, -0.9))]
    shares = np.arange(0.1, 0.95, 0.1)
    random = np.random.default_rng(2)
    taps: list[fc.Tap | fc.FootTap] = []
    for wall in walls:
        a, b = np.array(wall)
        at = np.array([a + (b - a) * share for share in shares])
        for pixel, seen in zip(SKEWED.pixels(at), SKEWED.sees(at), strict=True):
            u, v = pixel + random.normal(0.0, 1.0, 2)
            if seen:
                taps.append(fc.FootTap((float(u), float(v)), wall))
    assert len(taps) >= 8
    found = fc.calibrate(MOUNTED, taps)
    assert isinstance(found, fc.Calibration)
    assert _error_m(found.camera, SKEWED) < 0.08


def _refused(taps: list[fc.Tap]) -> str:
    found = fc.calibrate(MOUNTED, list(taps))
    return found.reason if isinstance(found, fc.Refused) else ""


def test_bad_sets_are_refused_with_the_reason() -> None:
    good = _taps(SKEWED)
    assert _refused(good[:5]) == fc.FEW
    assert _refused(good[:1] * 8) == fc.SPREAD
    line = SKEWED.pixels(np.array([(1.2 + 0.2 * k, 0.0) for k in range(7)]))
    in_line = [fc.Tap((float(u), float(v)), (1.2 + 0.2 * k, 0.0)) for k, (u, v) in enumerate(line)]
    assert _refused(in_line) == fc.SPREAD
    for scale in (100.0, 1000.0, 0.01):
        scaled = [fc.Tap(t.pixel, (scale * t.place_m[0], scale * t.place_m[1])) for t in good]
        assert _refused(scaled) == fc.UNITS
    assert _refused([fc.Tap((900.0, 300.0), (1.0, 0.0)), *good]) == fc.OUTSIDE
    mirrored = [fc.Tap(t.pixel, (t.place_m[0], -t.place_m[1])) for t in good]
    assert _refused(mirrored) == fc.SWAPPED
    turned = [fc.Tap(t.pixel, (t.place_m[1], t.place_m[0])) for t in good]
    assert _refused(turned) == fc.AXES


def test_the_tap_that_is_wrong_is_named() -> None:
    taps = _taps(SKEWED)
    taps[4] = fc.Tap(taps[4].pixel, (2.4, 0.2))
    found = fc.calibrate(MOUNTED, taps)
    assert isinstance(found, fc.Refused)
    assert (found.reason, found.worst) == (fc.RESIDUAL, 4)
    assert fc.RESIDUAL_M < (found.residual_m or 0.0) < 0.5


def test_feet_for_metres_are_refused() -> None:
    """Feet read as metres: the camera would sit higher than any chair's."""
    feet = [fc.Tap(t.pixel, (3.28 * t.place_m[0], 3.28 * t.place_m[1])) for t in _taps(SKEWED)]
    assert _refused(feet) in (fc.UNITS, fc.RESIDUAL, fc.UNSURE)
