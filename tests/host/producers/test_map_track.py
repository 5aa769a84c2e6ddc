"""The pose in a map of the newest estimate, where two estimates have the same time."""

from __future__ import annotations

import math
from dataclasses import replace

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


@pytest.mark.parametrize(
    ("mounting_deg", "sigma_m", "sigma_deg", "known"),
    [
        (1.0, 0.02, 0.3, True),
        (1.0, 0.11, 3.1, True),
        (1.0, 0.02, 5.6, False),
        (1.0, 0.14, 0.3, False),
        # Just started: what the lidars' directions may be off is no reason not to drive.
        (5.5, 0.02, 5.6, True),
        (5.5, 0.14, 6.2, True),
        (5.5, 0.02, 8.0, False),
        (5.5, 0.17, 5.6, False),
    ],
)
def test_a_pose_may_be_less_sure_by_lidars_whose_directions_are_not_verified(
    mounting_deg: float, sigma_m: float, sigma_deg: float, known: bool
) -> None:
    """By as much as at the look: later estimates may know better, and the look's pose does not."""
    track = MapTrack()
    where = Whereabouts(2.0, "home", 5.0, 1.0, 90.0, sigma_m, sigma_deg, 1.0)
    mounting_m = math.radians(mounting_deg)  # of a lidar 1 m from the axle
    where = replace(where, mounting_m=mounting_m, mounting_deg=mounting_deg)
    track.take([_estimate(2.0, 3.0)], where)
    assert (track.pose("home", 2.1) is not None) is known
