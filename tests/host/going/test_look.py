"""Go where I look: a goal without a map is seen, wide enough, and faces away from the chair."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.base.footprint import Footprint, Margins
from gazechair.going.costmap import costmap_of
from gazechair.going.look import TOO_NEAR, UNSEEN, goal, seen_from_here
from gazechair.going.plan import GOAL_BLOCKED, NoPath, Path, Planner, Pose
from gazechair.sensing.mapping.building.mapper import KeyScan

POSE: Pose = (5.0, -2.0, 1.1)


def _scan() -> KeyScan:
    """A room from x -2 to 4, y -2 to 2, a post at (2.5, 1.2); lidars ahead and behind."""
    points, origins = [], []
    for origin in ((0.6, 0.0), (-0.4, 0.0)):
        for angle in np.radians(np.arange(0.0, 360.0, 0.5)):
            c, s = math.cos(angle), math.sin(angle)
            far = min(
                ((4.0 if c > 0 else -2.0) - origin[0]) / c if abs(c) > 1e-9 else 99.0,
                (2.0 if s > 0 else -2.0) / s if abs(s) > 1e-9 else 99.0,
            )
            towards = (2.5 - origin[0]) * c + 1.2 * s
            aside = abs((2.5 - origin[0]) * s - 1.2 * c)
            if towards > 0.0 and aside < 0.15:
                far = min(far, towards)
            points.append((origin[0] + far * c, origin[1] + far * s))
            origins.append(origin)
    return KeyScan(np.array(POSE), np.array(points), np.array(origins), POSE[2], 0.0, 0.0)


@pytest.fixture(scope="module", name="seen")
def _seen():  # type: ignore[no-untyped-def]
    grid = seen_from_here([_scan(), _scan()], Footprint())
    return grid, costmap_of(grid, Footprint())


def test_a_free_spot_is_a_goal_that_faces_along_the_way(seen) -> None:  # type: ignore[no-untyped-def]
    found = goal((2.0, -0.5), POSE, *seen)
    assert not isinstance(found, NoPath)
    c, s = math.cos(POSE[2]), math.sin(POSE[2])
    assert found[:2] == pytest.approx((POSE[0] + 2 * c + 0.5 * s, POSE[1] + 2 * s - 0.5 * c))
    along = POSE[2] + math.atan2(-0.5, 2.0)
    assert found[2] == pytest.approx(math.remainder(along, 2.0 * math.pi))


@pytest.mark.parametrize(("front_m", "turned"), [(0.05, False), (0.3, True)])
def test_before_a_wall_the_front_margin_stays_free(seen, front_m: float, turned: bool) -> None:  # type: ignore[no-untyped-def]
    """0.8 m before it the body fits along, with 15 cm before its front."""
    footprint = Footprint(margins=Margins(front_m=front_m))
    found = goal((3.2, 0.0), POSE, seen[0], costmap_of(seen[0], footprint))
    assert not isinstance(found, NoPath)
    assert (abs(math.remainder(found[2] - POSE[2], 2.0 * math.pi)) > 0.3) == turned


def test_what_is_within_a_wide_margin_is_not_the_floor_under_the_chair(seen) -> None:  # type: ignore[no-untyped-def]
    footprint = Footprint(margins=Margins(front_m=3.5))  # up to beyond the wall
    grid = seen_from_here([_scan(), _scan()], footprint)
    assert (grid.occupied == seen[0].occupied).all()


def test_the_planner_finds_the_way_there_without_a_map(seen) -> None:  # type: ignore[no-untyped-def]
    at = goal((1.6, -0.4), POSE, *seen)
    assert not isinstance(at, NoPath)
    path = Planner(seen[1], may_reverse=True).plan(POSE, at)
    assert isinstance(path, Path)
    assert path.length_m < 2.2


@pytest.mark.parametrize(
    ("spot", "reason"),
    [
        ((0.1, 0.1), TOO_NEAR),
        ((2.2, 1.1), GOAL_BLOCKED),  # against the post
        ((1.5, 1.95), GOAL_BLOCKED),  # at the wall's foot
        ((6.0, 0.0), UNSEEN),  # behind the wall
        ((30.0, 0.0), UNSEEN),
        ((3.3, 1.62), UNSEEN),  # behind the post
    ],
)
def test_other_spots_are_refused(seen, spot, reason) -> None:  # type: ignore[no-untyped-def]
    found = goal(spot, POSE, *seen)
    assert isinstance(found, NoPath)
    assert found.reason in (reason, GOAL_BLOCKED) if reason == UNSEEN else found.reason == reason


def test_where_it_stands_is_free_and_one_scan_is_no_map(seen) -> None:  # type: ignore[no-untyped-def]
    clear = seen[1].clearance_m(*(np.array([value]) for value in POSE))
    assert clear[0] > 0.0
    with pytest.raises(ValueError, match="1 scans"):
        seen_from_here([_scan()], Footprint())
