"""The pose in a map of the newest estimate, where two estimates have the same time."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.producers.track import MapTrack
from gazechair.sensing.mapping.locating.whereabouts import Whereabouts
from gazechair.sensing.odometry.odometry import Estimate


def _estimate(time_s: float, x_m: float) -> Estimate:
    return Estimate(time_s, x_m, *(0.0,) * 5, 0.01, 0.01, 0.1, 0.02, 1.0, (), 1)


def test_of_two_lidars_in_step_the_second_estimate_belongs_to_the_pose() -> None:
    track = MapTrack()
    where = Whereabouts(2.0, "home", 5.0, 1.0, 90.0, 0.02, 0.3, 1.0)
    track.take([_estimate(2.0, 3.0), _estimate(2.0, 3.02)], where)
    pose = track.pose("home", 2.1)
    assert pose is not None
    assert np.allclose(pose, (5.0, 1.0, math.radians(90.0)))


@pytest.mark.parametrize(("sigma_deg", "known"), [(0.3, True), (5.6, True), (8.0, False)])
def test_a_chair_that_has_just_started_may_drive_its_first_half_metre(
    sigma_deg: float, known: bool
) -> None:
    track = MapTrack()
    where = Whereabouts(2.0, "home", 5.0, 1.0, 90.0, 0.05, sigma_deg, 1.0)
    track.take([_estimate(2.0, 3.0)], where)
    assert (track.pose("home", 2.1) is not None) is known
