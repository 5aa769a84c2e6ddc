"""Bends: arcs in place of vertices, where they have room, and how they are driven."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.going.bends import RATE_RAD_S, Bend, bend_at
from gazechair.going.follow import STOP, Follower, Stick
from gazechair.going.pace import PERIOD_S
from gazechair.going.plan import Path, Planner
from gazechair.going.smooth import Refused
from gazemeasure.obstacles.attack import KINDS, AttackedChair
from gazemeasure.turn.board import settings_with
from gazesim.chair import Chair
from goingrig import Box, floor, numbers

CORNER = np.array(((1.5, 1.5), (4.0, 1.5), (4.0, 3.5)))
LEFT = Bend.of(*CORNER.tolist(), 0.8)
HALL = (8.0, 6.0)


def test_an_arc_touches_both_legs() -> None:
    begin, end = LEFT.sampled()[[0, -1]]
    assert begin == pytest.approx((3.2, 1.5, 0.0))
    assert end == pytest.approx((4.0, 2.3, math.pi / 2))
    assert LEFT.length_m == pytest.approx(0.8 * math.pi / 2)


@pytest.mark.parametrize("mirrored", [1.0, -1.0])
def test_a_place_is_so_far_along_the_arc_and_left_of_it(mirrored: float) -> None:
    bend = Bend.of(*(CORNER * (1.0, mirrored)), 0.8)
    x, y, heading = bend.poses(np.array([0.5]))[0]
    left = 0.1 * np.array((-math.sin(heading), math.cos(heading)))
    assert bend.place(x + left[0], y + left[1]) == pytest.approx((0.5, 0.1))
    assert bend.place(x - left[0], y - left[1]) == pytest.approx((0.5, -0.1))


@pytest.mark.parametrize(
    ("boxes", "bends"),
    [
        ((), True),
        # A corridor's corner.
        (((0.0, 2.05, 3.45, 6.0), (4.55, 0.0, 8.0, 6.0), (0.0, 0.0, 4.55, 0.95)), False),
        (((4.85, 1.4, 5.1, 1.7),), False),  # it heads for what may be a person
        (((4.85, 0.0, 5.1, 1.7),), True),  # the same, a part of the wall
    ],
)
def test_it_bends_where_there_is_room(boxes: tuple[Box, ...], bends: bool) -> None:
    found = bend_at(floor(boxes, HALL), *CORNER, 0.8)
    assert (found is not None) is bends
    assert found is None or 0.3 < found.radius_m < 0.81


def test_ways_through_free_rooms_bend_and_not_where_the_board_refused_something() -> None:
    costmap = floor(((3.0, 0.0, 3.1, 3.6),), HALL)
    start, goal = (1.5, 1.5, math.pi / 2), (6.0, 1.5, -math.pi / 2)
    found = Planner(costmap).plan(start, goal)
    assert isinstance(found, Path)
    inner = range(1, len(found.points_m) - 1)
    assert any(found.bend(k) for k in inner)
    refused = [
        Refused(*found.points_m[k].tolist(), heading_rad=0.0, turns=True, price_s=12.0)
        for k in inner
        if found.bend(k)
    ]
    again = Planner(costmap).plan(start, goal, refused)
    assert isinstance(again, Path)
    for k in range(1, len(again.points_m) - 1):
        if again.bend(k) is not None:
            away_m = [math.dist(again.points_m[k], one.pose[:2]) for one in refused]
            assert min(away_m) > 0.9


class Driving:
    """A chair that follows a path with one bend; no board."""

    def __init__(self, kind: str = "twin") -> None:
        full = {"profile": 2, "linear_permille": 1000, "turn_permille": 1000}
        made = AttackedChair("3.1", kind, settings_with(full), True) if kind != "twin" else None
        self.chair: Chair | AttackedChair = made or Chair("3.1")
        self.chair.place(1.5, 1.5, 0.0)
        self.chair.step(0.01, (0.0, 0.0))
        self.follower = Follower(numbers())
        self.path = Path(CORNER, None, bends=(None, LEFT, None))
        self.follower.take(self.path, (1.5, 1.5, 0.0))
        self.stick = self.put_out = STOP
        self.off_m = self.seconds = 0.0

    def step(self, curves: bool = True, most_m_s: float = math.inf) -> Stick:
        chair = self.chair
        self.follower.moved(self.put_out, chair.speed_m_s, chair.yaw_rate_deg_s)
        pose = (chair.x_m, chair.y_m, math.radians(chair.heading_deg))
        self.stick = self.follower.step(pose, most_m_s, 0.5)
        curved = self.stick.linear_permille and self.stick.turn_permille
        self.put_out = STOP if curved and not curves else self.stick
        for _ in range(round(PERIOD_S / 0.01)):
            axes = self.put_out.linear_permille / 1000.0, self.put_out.turn_permille / 1000.0
            chair.step(0.01, axes)
        self.seconds += PERIOD_S
        turned, across = LEFT.place(chair.x_m, chair.y_m)
        if 0.0 <= turned <= math.pi / 2:
            self.off_m = max(self.off_m, abs(across))
        return self.stick


@pytest.mark.parametrize("kind", ["twin", *KINDS])
def test_a_bend_is_driven_without_a_stop(kind: str) -> None:
    driving = Driving(kind)
    speeds = []
    while not driving.follower.arrived and driving.seconds < 40.0:
        driving.step()
        speeds.append(driving.chair.speed_m_s)
    assert driving.follower.arrived
    assert math.dist((driving.chair.x_m, driving.chair.y_m), CORNER[2]) < 0.1
    assert driving.off_m < 0.10
    assert min(speeds[40:-40]) > 0.1
    turns_s = math.pi / 2 / RATE_RAD_S
    assert driving.seconds < 2.9 / 0.25 + turns_s + 4.0


def test_where_the_board_lets_no_curve_through_it_turns_at_the_vertex() -> None:
    driving = Driving()
    while driving.seconds < 40.0 and not driving.follower.turns_on_spot:
        driving.step(curves=False)
    assert driving.follower.turns_on_spot
    assert math.dist((driving.chair.x_m, driving.chair.y_m), CORNER[1]) < 0.15


def test_after_a_stop_for_somebody_a_bend_is_driven_as_before() -> None:
    driving = Driving()
    while driving.chair.x_m < 2.5:
        driving.step()
    driving.step(most_m_s=0.0)
    driving.put_out = Stick(300, -76)  # the board's report is late; it held the heading
    for _ in range(40):
        driving.step(most_m_s=0.0)
    assert driving.chair.speed_m_s == 0.0
    while not driving.follower.arrived and driving.seconds < 40.0:
        driving.step()
    assert driving.follower.arrived
    assert driving.off_m < 0.10
