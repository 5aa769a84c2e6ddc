"""Planner: doors, docking, bounded time, and a reason when there is no path."""

from __future__ import annotations

import itertools
import math
import time
from typing import Any

import numpy as np
import pytest

from gazechair.base.arrays import Float32Array, IntArray
from gazechair.base.footprint import Footprint, Margins
from gazechair.going.costmap import Costmap
from gazechair.going.distance_field import Distances, distances
from gazechair.going.lattice import STRICT_M, Lattice
from gazechair.going.plan import GOAL_BLOCKED, NO_WAY, START_BLOCKED, NoPath, Path, Planner, Pose
from gazechair.going.smooth import PASSES_M, Refused
from goingrig import TWO_ROOMS, floor

pytestmark = pytest.mark.costly

START, GOAL = (1.5, 2.0, 0.0), (6.5, 2.0, math.pi / 2)


def planned(
    boxes=TWO_ROOMS, start: Pose = START, goal=GOAL, reverse=False, **floor_of
) -> Path | NoPath:
    return Planner(floor(boxes, **floor_of), reverse).plan(start, goal)


def test_through_a_door() -> None:
    found = planned()
    assert isinstance(found, Path)
    assert found.clearance_m > 0.05
    assert found.points_m[0].tolist() == [1.5, 2.0]
    assert found.points_m[-1].tolist() == [6.5, 2.0]
    assert found.length_m < 5.5


@pytest.mark.parametrize("turned", [0.0, 13.0])
def test_through_a_door_of_85_centimetres(turned: float) -> None:
    narrow = ((3.95, 0.0, 4.05, 1.525), (3.95, 2.375, 4.05, 4.0))
    start = (1.5, 2.0, math.radians(turned))
    found = planned(narrow, start)
    assert isinstance(found, Path)
    assert found.clearance_m > 0.0


@pytest.mark.parametrize(("side_m", "through_y_m"), [(0.02, (1.55, 2.45)), (0.08, (3.3, 4.5))])
def test_a_wider_side_margin_takes_the_wider_of_two_doors(
    side_m: float, through_y_m: tuple[float, float]
) -> None:
    """The near one leaves 7 cm at each side: enough for the default margin only."""
    doors = ((3.95, 0.0, 4.05, 1.55), (3.95, 2.45, 4.05, 3.3), (3.95, 4.5, 4.05, 5.0))
    margins = Margins(side_m=side_m)
    found = planned(doors, goal=(6.5, 2.0, 0.0), size_m=(8.0, 5.0), margins=margins)
    assert isinstance(found, Path)
    x_m, y_m = found.points_m.T
    low_m, high_m = through_y_m
    assert low_m < float(np.interp(4.0, x_m, y_m)) < high_m


def test_a_wall_within_a_wide_front_margin_is_no_reason_not_to_back_off() -> None:
    start, goal = (7.15, 2.0, 0.0), (2.0, 2.0, math.pi)  # its front is 15 cm before the wall
    found = planned((), start, goal, reverse=True, margins=Margins(front_m=0.3))
    assert isinstance(found, Path)
    assert found.backward


def test_a_door_as_wide_as_the_chair_is_none() -> None:
    too_narrow = ((3.95, 0.0, 4.05, 1.65), (3.95, 2.35, 4.05, 4.0))
    assert planned(too_narrow) == NoPath(NO_WAY)


def test_a_goal_in_a_wall_is_blocked() -> None:
    assert planned(goal=(4.0, 0.7, 0.0)) == NoPath(GOAL_BLOCKED)


def test_a_start_in_an_obstacle_is_blocked() -> None:
    assert planned(start=(4.0, 0.7, 0.0)) == NoPath(START_BLOCKED)


def test_a_no_go_area_round_the_start() -> None:
    drawn = np.array(((0.5, 1.0), (2.5, 1.0), (2.5, 3.0), (0.5, 3.0)))
    assert planned(no_go=(drawn,)) == NoPath(START_BLOCKED)


def test_nothing_seen_is_no_floor() -> None:
    assert isinstance(planned(unseen=((0.0, 0.0, 8.0, 4.0),)), NoPath)


def test_docking_ends_straight_on() -> None:
    # Two narrow boxes 0.95 m apart: no room to turn between them.
    legs = ((6.6, 1.45, 7.6, 1.5), (6.6, 2.45, 7.6, 2.5))
    found = planned((*TWO_ROOMS, *legs), goal=(6.7, 1.975, 0.0))
    assert isinstance(found, Path)
    last = found.points_m[-1] - found.points_m[-2]
    assert abs(math.atan2(last[1], last[0])) < 0.05
    assert found.clearance_m > 0.03


def test_out_of_a_dead_end_backward_only_where_it_is_seen() -> None:
    niche = ((1.4, 1.45, 3.3, 1.5), (1.4, 2.5, 3.3, 2.55), (3.25, 1.45, 3.3, 2.55))
    start = (2.1, 2.0, 0.0)
    backward = planned(niche, start, (5.5, 2.0, 0.0), reverse=True)
    assert isinstance(backward, Path)
    assert backward.backward
    assert isinstance(planned(niche, start, (5.5, 2.0, 0.0)), NoPath)


def test_another_goal_is_planned_within_half_a_second() -> None:
    planner = Planner(floor(TWO_ROOMS))
    spent = []
    for y in (1.0, 1.5, 2.0, 2.5, 3.0):
        begin_s = time.process_time()
        assert isinstance(planner.plan(START, (6.5, y, 1.0)), Path)
        spent.append(time.process_time() - begin_s)
    assert sorted(spent)[2] < 0.5


def test_rotated_walls_are_no_obstacle_to_a_door() -> None:
    angle = math.radians(31.0)
    c, s = math.cos(angle), math.sin(angle)
    xs, ys = np.meshgrid(np.arange(0, 8, 0.01), np.arange(0, 4, 0.01), indexing="ij")
    walls = (np.abs(xs - 4.0) < 0.05) & (np.abs(ys - 2.0) > 0.475)
    walls |= (xs < 0.05) | (xs > 7.95) | (ys < 0.05) | (ys > 3.95)
    u, v = c * xs - s * ys + 3.0, s * xs + c * ys + 1.0
    occupied = np.zeros((420, 360), dtype=np.bool_)
    free = np.zeros_like(occupied)
    cells = (u / 0.025).astype(int), (v / 0.025).astype(int)
    free[cells] = True
    occupied[cells[0][walls], cells[1][walls]] = True
    costmap = Costmap(occupied, free & ~occupied, 0.025, np.zeros(2), Footprint())

    def turned(x: float, y: float, heading: float) -> Pose:
        return c * x - s * y + 3.0, s * x + c * y + 1.0, heading + angle

    found = Planner(costmap).plan(turned(1.5, 2.0, 0.0), turned(6.5, 2.0, 0.0))
    assert isinstance(found, Path)
    assert found.clearance_m > 0.0


def test_a_route_is_the_cheapest_by_the_prices_it_was_searched_with() -> None:
    lattice = Lattice(floor((*TWO_ROOMS, (5.0, 2.3, 5.3, 2.6))))
    ends = lattice.near(6.5, 2.4, 0.0, 0.08, 0.1)
    starts = lattice.near(1.5, 2.0, math.pi, 0.08, 0.1)
    costs = lattice.costs_to(ends, np.zeros(len(ends), dtype=np.int64), starts)
    route = lattice.route(costs, int(starts[0]))
    assert costs[route[-1]] == 0
    for at, after in itertools.pairwise(route):
        before, prices = lattice._before(np.array([after]))
        assert costs[at] == costs[after] + prices[(before == at) & (prices >= 0)].min()


def test_a_tighter_turn_is_taken_rather_than_a_long_way_round() -> None:
    # From a passage of 1.35 m to a door at its side; the other way round is 10 m, and narrow.
    boxes = (
        (0.0, 1.36, 2.55, 1.46),
        (3.50, 1.36, 6.3, 1.46),
        (6.3, 2.40, 6.4, 4.0),
        (7.17, 2.40, 8.0, 2.5),
    )
    found = planned(boxes, (1.0, 0.8, 0.0), (3.0, 3.2, math.pi / 2))
    assert isinstance(found, Path)
    assert found.clearance_m >= PASSES_M
    assert found.length_m < 6.0


A_LITTLE_OFF = math.radians(-5.0)
BEFORE_THE_DOOR: Pose = (2.58, 1.98, A_LITTLE_OFF)
AT_THE_DOOR: Pose = (3.45, 1.93, A_LITTLE_OFF)


def test_a_door_is_not_passed_at_the_heading_that_the_chair_happens_to_have() -> None:
    found = planned(start=BEFORE_THE_DOOR)
    assert isinstance(found, Path)
    assert found.clearance_m > 0.05
    assert found.cost_s < 60.0


def test_where_the_board_lets_no_turn_be_made_the_chair_backs_off_to_aim_again() -> None:
    planner = Planner(floor(TWO_ROOMS), True)
    found = planner.plan(AT_THE_DOOR, GOAL)
    assert isinstance(found, Path)
    assert not found.backward
    found = planner.plan(AT_THE_DOOR, GOAL, [Refused(*AT_THE_DOOR, True, 60.0)])
    assert isinstance(found, Path)
    assert found.backward
    assert found.points_m[1][0] < AT_THE_DOOR[0] - 0.2


def test_it_goes_straight_to_a_goal_where_a_leg_into_it_is_dearer() -> None:
    start, goal = (1.0, 3.0, math.radians(-30.0)), (3.1, 2.4, math.radians(-11.5))
    beside_where_it_would_begin = (1.7, 1.95, 2.0, 2.05)
    planner = Planner(floor((beside_where_it_would_begin,)))
    found = planner.plan(start, goal, [Refused(*start, False, 12.0)])
    assert isinstance(found, Path)
    assert len(found.points_m) == 2
    assert found.cost_s < 40.0


def test_where_no_turn_is_let_out_it_makes_no_side_step_of_5_cm_instead() -> None:
    start, goal = (4.0, 2.0, 0.0), (4.6, 2.22, math.radians(16.0))
    beside_the_goal = (4.2, 2.87, 5.2, 3.17)
    planner = Planner(floor((beside_the_goal,)), True)
    found = planner.plan(start, goal, [Refused(*start, True, 60.0)])
    assert isinstance(found, Path)
    assert np.hypot(*np.diff(found.points_m, axis=0).T).min() > 0.2
    assert found.cost_s < 60.0


def test_a_first_leg_that_would_end_in_a_door_is_left_out() -> None:
    leaf = (3.0, 2.475, 3.95, 2.525)
    frames = ((3.95, 0.0, 4.05, 1.5), (3.95, 2.475, 4.05, 4.0))
    found = planned((*frames, leaf), (2.5, 1.84, math.radians(5.0)))
    assert isinstance(found, Path)
    assert found.clearance_m > 0.05
    assert found.cost_s < 40.0  # a turn within the frame costs 40 s more


def test_a_goal_that_the_board_would_not_let_it_reach_is_reached_within_centimetres() -> None:
    # The goal is 0.2 m ahead, a wall 0.1 m beyond it: the board drives no nearer than 0.35 m.
    start, goal = (1.07, 1.12, 2.65), (0.85, 1.16, 0.0)
    found = planned((), start, goal, True, size_m=(3.0, 3.0))
    assert isinstance(found, Path)
    assert found.cost_s < 60.0
    assert 0.0 < math.dist(found.points_m[-1], goal[:2]) < 0.07


def test_close_to_the_goal_it_does_not_turn_back_to_come_straight() -> None:
    # A straight final leg of 0.3 m into the goal would begin behind the chair.
    boxes = ((0.0, 0.0, 1.0, 3.0), (2.58, 0.0, 3.0, 3.0), (1.49, 2.25, 2.09, 2.9))
    start, goal = (1.75, 1.13, math.radians(95.0)), (1.79, 1.29, math.pi / 2)
    found = planned(boxes, start, goal, True, size_m=(3.0, 3.0))
    assert isinstance(found, Path)
    assert found.length_m < 0.2
    assert found.cost_s < 60.0


POCKET = ((6.0, 1.2, 7.0, 1.55), (6.0, 2.45, 7.0, 2.8), (7.0, 1.2, 7.1, 2.8))
"""0.9 m wide: no turn fits."""
DOCKED = (6.2, 2.0, 0.0)


def turns_only(found: Path | NoPath) -> bool:
    return isinstance(found, Path) and found.length_m == 0.0


@pytest.mark.parametrize(("ahead_m", "turned_deg"), [(0.05, 0.0), (-0.08, 3.0), (0.11, -3.0)])
def test_a_chair_that_stands_in_its_pocket_has_arrived(ahead_m: float, turned_deg: float) -> None:
    start = (DOCKED[0] + ahead_m, 2.0, math.radians(turned_deg))
    found = planned(POCKET, start, DOCKED, True)
    assert turns_only(found)
    assert isinstance(found, Path)
    assert found.heading_rad is None


def test_at_its_goal_it_makes_only_the_last_turn_and_from_a_decimetre_away_it_drives() -> None:
    assert turns_only(planned((), (2.06, 2.0, 1.0), (2.0, 2.0, 0.0)))
    assert turns_only(planned((), (2.06, 2.0, 1.0), (2.0, 2.0)))
    away = planned((), (1.9, 2.0, 0.0), (2.0, 2.0, 0.0))
    assert isinstance(away, Path)
    assert away.points_m[-1].tolist() == [2.0, 2.0]


def test_no_turn_is_planned_into_a_wall() -> None:
    backed_in = (*DOCKED[:2], math.pi)
    found = planned(POCKET, backed_in, DOCKED, True)
    assert isinstance(found, Path)
    assert min(math.dist(one, DOCKED[:2]) for one in found.points_m[1:-1]) > 0.5
    shut = (*POCKET, (5.2, 1.2, 5.25, 2.8))
    assert planned(shut, backed_in, DOCKED, True) == NoPath(NO_WAY)


BEFORE_M, BEHIND_M = np.array(((2.0, 1.0), (2.0, 1.05))), np.array(((5.5, 2.0), (5.5, 2.05)))


def free_behind(lattice: Lattice) -> int:
    """Free poses at BEHIND_M, once the lattice is up to date."""
    lattice.refresh()
    lattice.use(STRICT_M, 0.03, ())
    return len(lattice.near(*BEHIND_M[0], 0.0, 0.1, 4.0))


def test_what_is_seen_while_the_lattice_is_computed_is_in_the_next_plan() -> None:
    costmap = floor()
    lattice = Lattice(costmap)
    clearances = lattice._clearances

    def meanwhile(places: IntArray) -> Float32Array:
        found = clearances(places)
        costmap.see(BEHIND_M, 1.1, (3.0, 2.0))
        costmap.refresh(1.1)
        return found

    costmap.see(BEFORE_M, 1.0, (3.0, 2.0))
    costmap.refresh(1.0)
    lattice._clearances = meanwhile  # type: ignore[method-assign]
    lattice.refresh()
    lattice._clearances = clearances  # type: ignore[method-assign]
    assert free_behind(lattice) == 0


def test_a_plan_made_while_distances_are_computed_does_not_hide_them_from_the_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    costmap = floor()
    lattice = Lattice(costmap)
    assert free_behind(lattice)

    def meanwhile(*of: Any) -> Distances:
        lattice.refresh()
        return distances(*of)

    costmap.see(BEHIND_M, 1.0, (3.0, 2.0))
    with monkeypatch.context() as patch:
        patch.setattr("gazechair.going.costmap.distances", meanwhile)
        costmap.refresh(1.0)
    assert free_behind(lattice) == 0


def test_past_a_door_leaf_it_drives_straight_on_before_it_turns() -> None:
    """The leaf is beside the chair's rear corner: a turn at once is refused, whatever it costs."""
    door = ((3.95, 0.0, 4.05, 0.925), (3.95, 1.9, 4.05, 4.0), (3.95, 0.9, 4.975, 0.975))
    boxes = (*door, (7.5, 1.6, 7.9, 2.4), (7.5, 2.85, 7.9, 3.65))
    start, goal = (5.23, 1.4, 0.0), (6.4, 1.63, -1.174)
    refused = Refused(*start, turns=True, price_s=30.0)
    for known in ((), (refused,), 3 * (refused,)):
        found = Planner(floor(boxes), may_reverse=True).plan(start, goal, known)
        assert isinstance(found, Path)
        assert found.points_m[1] == pytest.approx((found.points_m[1][0], start[1]), abs=0.01)
        assert found.points_m[1][0] > start[0] + 0.2
        assert found.cost_s < 60.0
