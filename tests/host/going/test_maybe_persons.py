"""Possible persons as seen from here, and paths that avoid them."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.going.maybe_persons import maybe_persons_m
from gazechair.going.plan import Path, Planner
from goingrig import LIDAR_M, floor


def strip(wide_m: float, ahead_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Beams to a wall 5 m ahead, and to the visible piece of a nearer one."""
    slopes = np.tan(np.radians(np.arange(-40.0, 40.0, 0.25)))
    ahead = np.where(np.abs(slopes * ahead_m) < 0.5 * wide_m, ahead_m, 5.0)
    ends = np.array(LIDAR_M) + np.stack((ahead, slopes * ahead), axis=1)
    return ends, np.tile(LIDAR_M, (len(ends), 1))


@pytest.mark.parametrize(
    ("wide_m", "ahead_m", "like_one"),
    [(0.3, 1.2, True), (0.6, 1.2, True), (1.2, 1.2, False), (0.03, 1.2, False), (0.3, 2.5, False)],
)
def test_as_wide_as_a_person_and_near(wide_m: float, ahead_m: float, like_one: bool) -> None:
    found = maybe_persons_m(*strip(wide_m, ahead_m))
    assert bool(len(found)) is like_one
    if like_one:
        assert found[:, 0] == pytest.approx(LIDAR_M[0] + ahead_m, abs=0.01)


def test_a_way_keeps_off_what_looks_like_a_person_from_here() -> None:
    costmap = floor()
    planner, start, goal = Planner(costmap), (1.0, 2.0, 0.0), (6.5, 2.0, 0.0)
    ways = []
    for seen in (np.zeros((0, 2)), np.array(((3.8, 1.70), (3.8, 1.76))), np.zeros((0, 2))):
        costmap.suspect(seen)
        path = planner.plan(start, goal)
        assert isinstance(path, Path)
        legs = zip(path.points_m[:-1], path.points_m[1:], strict=True)
        assert sum(costmap.ahead.leg_s(seen, a, b, False) for a, b in legs) == 0.0
        ways.append(path)
    assert ways[0].points_m[:, 1].max() < 2.05 < ways[1].points_m[:, 1].max()
    assert ways[2].points_m == pytest.approx(ways[0].points_m)
