"""The benchmark of going where one looks: spots found by gaze, without the drives."""

from __future__ import annotations

import numpy as np

from gazemeasure.go.floor import MAGNIFIED, NOISE, SWITCH, off_m
from gazemeasure.go.line import calibrated, random_eye


def test_spots_are_found_within_the_limit() -> None:
    random = np.random.default_rng(8)
    eye = random_eye(random)
    camera = calibrated(eye, random)
    assert camera is not None
    for kind in (NOISE, MAGNIFIED, SWITCH):
        offs = [off_m(eye, camera, kind, random) for _ in range(60)]
        assert np.median([off for off in offs if off is not None]) < 0.2
