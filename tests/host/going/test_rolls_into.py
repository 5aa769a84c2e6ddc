"""Into another path without a stop: where the chair rolls, and a bend into it has room."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gazechair.going import rolls_into
from gazechair.going.bends import RATE_RAD_S, Bend, Point
from gazechair.going.costmap import Costmap
from gazechair.going.mission import ARRIVED, DRIVING
from gazechair.going.plan import Path, Pose
from gazechair.going.rolls_into import Rolling, rolled_into, turns_at_stop, turns_rolling
from goingrig import TWO_ROOMS, Box, GoingChair, floor

pytestmark = pytest.mark.costly

HALL = (10.0, 5.0)
AT, BEGIN = (3.0, 2.0, 0.0), (3.25, 2.0, 0.0)
ROLLS = Rolling(AT, BEGIN, 0.35, 0.0, RATE_RAD_S, 0.3)
ASIDE = Path(np.array([AT[:2], (5.5, 3.0)]), None, clearance_m=0.3)


def test_it_bends_from_where_it_turns_as_requested_now() -> None:
    found = rolled_into(floor((), HALL), ASIDE, ROLLS)
    assert found is not None
    bend = found.bend(1)
    assert bend is not None
    assert bend.begin_m == pytest.approx(BEGIN[:2])
    assert bend.radius_m * RATE_RAD_S == pytest.approx(0.35, rel=0.05)
    assert np.array_equal(found.points_m[[0, -1]], ASIDE.points_m)
    assert found.began_rad == pytest.approx(math.atan2(1.0, 2.5))


@pytest.mark.parametrize("end", [(3.9, 3.8), (3.8, 3.6), (4.2, 0.9)])
def test_far_aside_the_bend_is_as_sharp_as_a_slower_chair_drives_it(end: Point) -> None:
    path = replace(ASIDE, points_m=np.array([AT[:2], end]))
    found = rolled_into(floor((), HALL), path, ROLLS)
    assert found is not None
    bend = found.bend(1)
    assert bend is not None
    assert 60.0 < abs(math.degrees(bend.angle_rad)) < 100.0
    assert bend.radius_m * RATE_RAD_S < 0.3
    leaves = bend.poses(np.array([abs(bend.angle_rad)]))[0]
    leads = math.atan2(end[1] - leaves[1], end[0] - leaves[0])
    assert leads == pytest.approx(leaves[2], abs=0.01)


BEHIND = replace(ASIDE, points_m=np.array([AT[:2], (2.0, 3.5)]))


def test_it_turns_while_it_brakes_where_any_heading_is_free() -> None:
    assert turns_rolling(floor((), HALL), BEHIND, ROLLS)


@pytest.mark.parametrize(
    "box",
    [
        (3.2, 2.5, 3.6, 2.9),  # on the side to which it turns
        (4.0, 1.9, 4.2, 2.1),  # ahead of where it stops
        (2.6, 1.2, 2.9, 1.5),  # its rear would come there
    ],
)
def test_it_stops_before_it_turns_where_something_is_beside_its_way_to_the_stop(box: Box) -> None:
    assert not turns_rolling(floor((box,), HALL), BEHIND, ROLLS)


def test_to_a_near_place_that_it_rolls_past_it_turns_farther_than_to_the_leg() -> None:
    near = replace(ASIDE, points_m=np.array([(2.6, 2.0), (2.95, 2.6)]))
    assert turns_rolling(floor((), HALL), near, ROLLS)
    behind = floor(((2.2, 2.5, 2.4, 2.7),), HALL)  # in reach of a turn by more than 75 degrees
    assert not turns_rolling(behind, near, ROLLS)
    assert turns_at_stop(behind, near, ROLLS)


def test_where_it_stops_it_turns_only_with_room_and_to_a_leg_that_it_does_not_pass() -> None:
    assert turns_at_stop(floor((), HALL), BEHIND, ROLLS)
    assert not turns_at_stop(floor(((3.2, 2.5, 3.6, 2.9),), HALL), BEHIND, ROLLS)
    assert not turns_at_stop(
        floor((), HALL), replace(ASIDE, points_m=np.array([(2.6, 2.0), (3.2, 2.0)])), ROLLS
    )


def test_it_stops_before_a_turn_to_a_path_that_begins_backward_or_with_no_leg() -> None:
    hall = floor((), HALL)
    assert not turns_rolling(hall, replace(BEHIND, backward=True), ROLLS)
    assert not turns_rolling(hall, replace(BEHIND, points_m=np.array([AT[:2], (3.1, 2.0)])), ROLLS)


@pytest.mark.parametrize(
    "boxes",
    [
        ((4.2, 1.0, 4.6, 1.75),),  # a table: the board wants room straight ahead, too
        ((3.4, 2.5, 4.0, 3.2),),  # beside the bend
        ((4.9, 2.55, 5.1, 2.65),),  # on the leg after it
        ((5.55, 3.0, 5.75, 3.2),),  # the leg leads to what may be a person
    ],
)
def test_where_a_bend_has_no_room_it_stops_and_turns(boxes: tuple[Box, ...]) -> None:
    assert rolled_into(floor(boxes, HALL), ASIDE, ROLLS) is None


def test_glass_that_is_drawn_leaves_no_room() -> None:
    glass = np.array([(3.3, 2.45), (4.2, 2.45), (4.2, 2.47), (3.3, 2.47)])
    assert rolled_into(floor((), HALL, no_go=[glass]), ASIDE, ROLLS) is None


@pytest.mark.parametrize(
    ("path", "rolling"),
    [
        (replace(ASIDE, backward=True), ROLLS),
        (ASIDE, replace(ROLLS, turns_deg_s=-10.0)),  # it still turns to the other side
        (replace(ASIDE, points_m=np.array([AT[:2], (3.3, 2.6)])), ROLLS),  # too sharp
        (replace(ASIDE, points_m=np.array([AT[:2], (3.7, 2.15)])), ROLLS),  # too near
    ],
)
def test_what_a_bend_cannot_lead_into_is_turned_to(path: Path, rolling: Rolling) -> None:
    assert rolled_into(floor((), HALL), path, rolling) is None


@pytest.mark.parametrize(("speed_m_s", "tries"), [(0.35, 3), (0.12, 2), (0.09, 1)])
def test_no_radius_is_tried_twice(
    speed_m_s: float, tries: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    radii: list[float] = []

    def no_room(_costmap: Costmap, bend: Bend) -> bool:
        radii.append(round(bend.radius_m, 3))
        return False

    monkeypatch.setattr(rolls_into, "has_room", no_room)
    assert rolled_into(floor((), HALL), ASIDE, replace(ROLLS, speed_m_s=speed_m_s)) is None
    assert radii == sorted(set(radii), reverse=True)
    assert len(radii) == tries


def test_past_a_leg_that_is_too_short_it_leads_to_the_next() -> None:
    points = np.array([AT[:2], (3.35, 2.06), (6.0, 3.2)])
    found = rolled_into(floor((), HALL), replace(ASIDE, points_m=points), ROLLS)
    assert found is not None
    assert len(found.points_m) == 3
    assert found.bend(1) is not None


def test_the_bend_after_it_fits_the_leg_from_it() -> None:
    points = np.array([*ASIDE.points_m, (8.0, 3.0)])
    after = Bend.of(*points.tolist(), 0.5)
    path = replace(ASIDE, points_m=points, bends=(None, after, None))
    found = rolled_into(floor((), HALL), path, ROLLS)
    assert found is not None
    assert len(found.points_m) == 4
    bend = found.bend(2)
    assert bend is not None
    assert bend.tangent_m == pytest.approx(0.5)
    leg = found.points_m[2] - found.points_m[1]
    assert bend.begin_rad == pytest.approx(math.atan2(leg[1], leg[0]))


def redirected(goal: Pose, boxes: tuple[Box, ...] = ()) -> tuple[GoingChair, float, float]:
    """A chair that got another goal while it rolled straight on.

    Also the seconds until it truly turned, and its lowest speed within 3 s.
    """
    chair = GoingChair(floor(boxes, HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(8.0)
    assert chair.chair.speed_m_s > 0.3
    chair.mission.go(goal)
    at_s, turns_s, least_m_s = chair.now_s, math.inf, math.inf
    for _ in range(60):
        chair.step()
        if abs(chair.chair.yaw_rate_deg_s) > 2.0:
            turns_s = min(turns_s, chair.now_s - at_s)
        least_m_s = min(least_m_s, chair.chair.speed_m_s)
    return chair, turns_s, least_m_s


@pytest.mark.parametrize("goal", [(5.5, 3.0, 0.0), (6.5, 3.3, 0.5), (6.0, 0.8, 0.0)])
def test_another_goal_aside_is_steered_to_at_once_and_without_a_stop(goal: Pose) -> None:
    chair, turns_s, least_m_s = redirected(goal)
    assert turns_s <= 0.5
    assert least_m_s > 0.2
    assert chair.run(60.0) == ARRIVED
    assert math.dist(chair.pose[:2], goal[:2]) < 0.1


@pytest.mark.parametrize("goal", [(2.0, 3.6, 0.0), (1.0, 1.0, 2.0)])
def test_to_another_goal_behind_it_turns_before_it_has_stopped(goal: Pose) -> None:
    chair, turns_s, _ = redirected(goal)
    assert turns_s <= 0.55
    assert chair.run(60.0) == ARRIVED
    assert math.dist(chair.pose[:2], goal[:2]) < 0.1


def test_beside_a_table_it_is_not_nearer_than_by_turning_on_the_spot() -> None:
    table = ((4.3, 2.6, 5.2, 3.4),)
    chair, _, _ = redirected((6.4, 3.4, 0.0), table)
    assert chair.run(60.0) == ARRIVED
    assert chair.least_m > 0.05


def test_back_to_the_goal_before_and_twice_at_once_it_arrives_where_it_was_sent_last() -> None:
    chair, _, _ = redirected((6.0, 3.2, 0.0))
    chair.mission.go((6.5, 0.9, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    assert chair.run(60.0) == ARRIVED
    assert math.dist(chair.pose[:2], (8.5, 2.0)) < 0.1


def test_through_a_door_it_arrives_with_the_door_s_room() -> None:
    chair = GoingChair(floor(TWO_ROOMS), (1.5, 2.0, 0.0))
    chair.mission.go((3.0, 2.0, 0.0))
    chair.run(3.0)
    assert chair.mission.state == DRIVING
    chair.mission.go((6.5, 2.6, 0.0))
    assert chair.run(60.0) == ARRIVED
    assert chair.least_m > 0.02
