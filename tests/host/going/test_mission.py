"""Mission: arrival, reported obstacles, a lost pose, pause, a change of goal, people."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gazechair.base.footprint import Footprint, Margins
from gazechair.going.follow import STOP, Pose, Stick
from gazechair.going.mission import ARRIVED, BLOCKED, DRIVING, LOST, POSE_LOST, WAITING, at_once
from gazechair.going.pace import ACCELERATE_M_S2, PERIOD_S
from gazechair.going.path import Abandoned
from gazechair.going.people import People
from gazechair.going.plan import GOAL_BLOCKED, NO_WAY, Path, Planner
from gazechair.going.planning import Planned
from goingrig import TWO_ROOMS, Box, GoingChair, Person, drive_among, floor

pytestmark = pytest.mark.costly

START, GOAL = (1.5, 2.0, 0.0), (6.5, 2.0, math.pi / 2)


@pytest.fixture
def chair() -> GoingChair:
    made = GoingChair(floor(TWO_ROOMS), START)
    made.mission.go(GOAL)
    return made


def test_through_a_door_to_a_heading(chair: GoingChair) -> None:
    assert chair.run(90.0) == ARRIVED
    chair.run(1.0)
    assert math.dist(chair.pose[:2], GOAL[:2]) < 0.1
    assert abs(math.degrees(chair.pose[2] - GOAL[2])) < 4.0
    assert chair.least_m > 0.02


def test_backward_out_of_a_niche_the_room_behind_counts() -> None:
    niche = ((1.4, 1.45, 3.3, 1.5), (1.4, 2.5, 3.3, 2.55), (3.25, 1.45, 3.3, 2.55))
    chair = GoingChair(floor(niche), (2.1, 2.0, 0.0))
    chair.mission.planner = Planner(chair.mission.costmap, may_reverse=True)
    chair.mission.go((5.5, 2.0, 0.0))
    while chair.asked.linear_permille >= 0:
        chair.step()
        assert chair.now_s < 4.0
    assert chair.mission._ahead.straight_m > 0.05


@pytest.mark.parametrize(
    ("boxes", "off", "turns_deg"),
    [
        (((6.0, 1.2, 7.0, 1.55), (6.0, 2.45, 7.0, 2.8), (7.0, 1.2, 7.1, 2.8)), (0.05, 0.0, 3.0), 0),
        (((7.05, 1.0, 7.3, 3.0),), (0.03, 0.05, 2.0), 5.0),
        ((), (-0.03, 0.06, 40.0), 45.0),
    ],
    ids=["in its pocket", "at its table", "on a free floor"],
)
def test_where_it_stands_already_it_makes_the_last_turn_at_most(
    boxes: tuple[Box, ...], off: Pose, turns_deg: float
) -> None:
    chair = GoingChair(floor(boxes), (6.2 + off[0], 2.0 + off[1], math.radians(off[2])))
    chair.mission.planner = Planner(chair.mission.costmap, may_reverse=True)
    chair.mission.go((6.2, 2.0, 0.0))
    turned_deg, before = 0.0, chair.chair.heading_deg
    while chair.mission.state != ARRIVED:
        chair.step()
        turned_deg += abs(chair.chair.heading_deg - before)
        before = chair.chair.heading_deg
        assert chair.now_s < 10.0
    assert turned_deg <= turns_deg


def test_another_goal_on_the_way(chair: GoingChair) -> None:
    chair.run(8.0)
    chair.mission.go((6.5, 1.0, 0.0))
    moves = [chair.step() != STOP for _ in range(10)]
    assert any(moves)
    assert chair.run(90.0) == ARRIVED
    assert math.dist(chair.pose[:2], (6.5, 1.0)) < 0.1


def test_a_chair_found_beside_its_goal_at_the_end_goes_there(chair: GoingChair) -> None:
    chair.mission._follower.step = end_of_way(chair)  # type: ignore[method-assign]
    assert chair.run(90.0) == ARRIVED
    chair.run(1.0)
    assert math.dist(chair.pose[:2], GOAL[:2]) < 0.12


def end_of_way(chair: GoingChair) -> Callable[[Pose, float, float, float], Stick]:
    """The follower's step, whose path ends, once, 0.4 m early."""
    follower = chair.mission._follower
    step = follower.step
    ended: list[bool] = []

    def shorter(pose: Pose, most_m_s: float, room_m: float, straight_m: float) -> Stick:
        if not ended and math.dist(pose[:2], GOAL[:2]) < 0.4:
            ended.append(True)
            follower.arrived = True
        return step(pose, most_m_s, room_m, straight_m)

    return shorter


def test_it_drives_on_until_the_new_way_is_known(chair: GoingChair) -> None:
    chair.run(8.0)
    jobs: list[tuple[Callable[[], Planned], Future[Planned]]] = []

    def later(job: Callable[[], Planned]) -> Future[Planned]:
        jobs.append((job, Future()))
        return jobs[-1][1]

    chair.mission.submit = later
    chair.mission.go((6.5, 1.0, 0.0))
    old = chair.mission.path
    assert all(chair.step() != STOP for _ in range(6))
    chair.mission.go((6.5, 1.5, 0.0))  # before the plan is ready: the later goal counts
    with pytest.raises(Abandoned):
        jobs[0][0]()
    for n in range(2):
        chair.step()
        chair.step()
        assert len(jobs) == 2 + n
        if not n:
            job, found = jobs[1]
            found.set_result(job())
    assert chair.mission.path is not old
    job, found = jobs[2]  # a better path
    found.set_result(job())
    chair.mission.submit = at_once
    assert chair.run(90.0) == ARRIVED
    assert math.dist(chair.pose[:2], (6.5, 1.5)) < 0.1


def test_in_a_hurry_the_first_way_is_driven_and_a_better_one_taken_when_it_is_known(
    chair: GoingChair, monkeypatch: pytest.MonkeyPatch
) -> None:
    chair.run(8.0)
    plan, asked = chair.mission.planner.plan, []

    def hard_at_first(*of: Any) -> Planned:
        asked.append(of[3])
        found = plan(*of)
        assert isinstance(found, Path)
        return replace(found, cost_s=found.cost_s + 50.0 * (len(asked) == 1))

    monkeypatch.setattr(chair.mission.planner, "plan", hard_at_first)
    ways = []
    for goal in ((6.5, 1.0, 0.0), (6.5, 1.5, 0.0)):
        chair.mission.go(goal)
        for _ in range(3):
            chair.step()
            ways.append(chair.mission.path)
    assert asked == [True, False, True, False]
    first, better, _, other, same, _ = ways
    assert first is not better
    assert other is same


def test_no_better_way_stays_unless_it_had_to_stop_for_one(chair: GoingChair) -> None:
    chair.run(8.0)
    mission = chair.mission
    plan = mission.planner.plan

    def hard(*of: Any) -> Planned:
        found = plan(*of)
        assert isinstance(found, Path)
        return replace(found, cost_s=100.0)

    mission.planner.plan = hard  # type: ignore[method-assign]
    mission.go((6.5, 1.0, 0.0))
    chair.step()
    first = mission.path
    chair.step()
    assert mission.path is first
    mission.go((6.5, 1.5, 0.0))
    chair.step()
    first = mission.path
    mission._ask_plan()
    chair.step()
    assert mission.path is not first


def test_where_nothing_is_let_out_it_asks_a_third_of_the_time(chair: GoingChair) -> None:
    chair.run(8.0)
    chair.refuses = True
    chair.run(2.0)
    asked = 0
    for _ in range(200):
        chair.step()
        asked += chair.asked != STOP
    assert 10 < asked < 80


def test_a_lost_pose_is_said_within_half_a_second_and_nothing_moves(chair: GoingChair) -> None:
    chair.run(8.0)
    chair.located = False
    chair.now_s += 0.01
    for _ in range(7):  # 0.36 s: the chair needs the rest to stop
        chair.step()
    assert (chair.mission.state, chair.mission.reason) == (LOST, POSE_LOST)
    assert chair.stick == STOP
    plans = chair.mission.plans
    chair.located = True
    chair.run(1.0)
    assert (chair.mission.state, chair.mission.plans) == (DRIVING, plans)  # along its path
    assert chair.run(90.0) == ARRIVED


def test_a_pose_that_jumps_half_a_metre_makes_another_plan(chair: GoingChair) -> None:
    chair.run(8.0)
    plans = chair.mission.plans
    chair.chair.place(chair.pose[0] - 0.5, chair.pose[1], math.degrees(chair.pose[2]))
    chair.step()
    chair.step()
    assert chair.mission.plans == plans + 1
    assert chair.run(90.0) == ARRIVED


def test_a_board_that_lets_nothing_out_is_said_within_ten_seconds(chair: GoingChair) -> None:
    chair.run(8.0)
    chair.refuses = True
    chair.run(3.5)
    assert chair.mission.state == WAITING
    chair.run(30.0)
    assert chair.mission.reason


def test_a_goal_in_a_wall_is_said_at_once() -> None:
    chair = GoingChair(floor(TWO_ROOMS), START)
    chair.mission.go((4.0, 0.5, 0.0))
    chair.run(0.2)
    assert (chair.mission.state, chair.mission.reason) == (BLOCKED, GOAL_BLOCKED)


def test_a_door_that_is_closed_now_is_said_within_ten_seconds(chair: GoingChair) -> None:
    door = np.stack((np.full(60, 4.0), np.linspace(1.45, 2.45, 60)), axis=1)
    said = None
    for k in range(400):
        chair.step()
        if k % 2 == 0:
            x, y, heading = chair.pose
            c, s = math.cos(heading), math.sin(heading)
            own = (door - (x, y)) @ np.array(((c, -s), (s, c)))
            chair.mission.scan(own, np.zeros_like(own), chair.now_s, chair.pose)
        if chair.mission.state == BLOCKED:
            said = chair.now_s
            break
    assert said is not None
    assert said < 10.0 + 5.0
    assert chair.least_m > 0.0


def test_who_walks_to_and_fro_behind_the_door_does_not_shut_the_way(chair: GoingChair) -> None:
    def walks(now_s: float) -> list[Person]:
        return [(5.0, 2.0 + 1.2 * math.sin(now_s))] if now_s < 15.0 else []

    said = drive_among(chair, 90.0, walks)
    assert said[-1][0] == ARRIVED
    assert BLOCKED not in {state for state, _ in said}


def test_who_stands_in_the_door_for_a_while_is_waited_for_nearby(chair: GoingChair) -> None:
    waits_s: list[float] = []

    def stands(now_s: float) -> list[Person]:
        if chair.mission.state == WAITING:
            waits_s.append(now_s)
        leaves_s = waits_s[0] + 5.5 if waits_s else math.inf
        return [(4.0, 2.0)] if 3.0 < now_s < leaves_s else []

    said = drive_among(chair, 90.0, stands)
    assert waits_s[0] < 6.0
    assert said[-1][0] == ARRIVED
    assert BLOCKED not in {state for state, _ in said}
    assert len(said) * PERIOD_S < 45.0


def test_who_stands_in_the_only_door_for_good_is_waited_for_nearby_and_then_said(
    chair: GoingChair,
) -> None:
    said = drive_among(chair, 20.0, lambda now_s: [(4.0, 2.0)] if now_s > 0.2 else [])
    assert all(reason for _, reason in said[60:])
    assert said[-1] == (BLOCKED, NO_WAY)
    assert 2.5 < chair.pose[0] < 4.0 - 0.15 - 0.3
    assert chair.stick == STOP


@pytest.mark.parametrize(("leaves_s", "far_round"), [(6.0, False), (math.inf, True)])
def test_who_stands_in_the_near_door_is_waited_for_before_it_goes_far_round(
    leaves_s: float, far_round: bool
) -> None:
    two_doors = ((3.95, 0.0, 4.05, 1.45), (3.95, 2.45, 4.05, 6.2), (3.95, 7.2, 4.05, 8.0))
    chair = GoingChair(floor(two_doors, (8.0, 8.0)), START)
    chair.mission.go(GOAL)
    farthest_m = []

    def stands(now_s: float) -> list[Person]:
        farthest_m.append(chair.pose[1])
        return [(4.0, 2.0)] if 0.2 < now_s < leaves_s else []

    said = drive_among(chair, 150.0, stands)
    assert said[-1][0] == ARRIVED
    assert (max(farthest_m) > 4.0) is far_round


def stand_on_both_sides(chair: GoingChair) -> None:
    """Two possible persons ahead, not on the path, for a while."""
    x, y, _ = chair.pose
    seen = [(x + 0.9, y + side * off_m) for side in (-1, 1) for off_m in (0.42, 0.46, 0.5)]
    chair.mission.costmap.see(np.array(seen), chair.now_s + 20.0, (x, y))


def test_a_pose_that_wanders_is_no_motion_of_a_chair_that_the_board_holds(
    chair: GoingChair,
) -> None:
    chair.run(8.0)
    stand_on_both_sides(chair)
    chair.refuses, chair.wanders_m = True, 0.025
    chair.run(2.0)
    for _ in range(200):
        chair.step()
        assert chair.mission.state == WAITING


def test_before_what_may_be_a_person_it_stands_still_where_no_other_way_is_better(
    chair: GoingChair,
) -> None:
    chair.run(8.0)
    stand_on_both_sides(chair)
    before, plans = chair.mission.path, chair.mission.plans
    chair.refuses, chair.wanders_m = True, 0.02
    chair.run(10.0)
    assert chair.mission.plans == plans + 1
    assert chair.mission.path is before


def test_before_whatever_else_it_does_not_wait_but_aims_anew_and_soon_says_that_there_is_no_way(
    chair: GoingChair,
) -> None:
    chair.run(8.0)
    before = chair.mission.path
    chair.refuses = True
    said = [state for state, _ in drive_among(chair, 10.0, lambda _: [])]
    assert chair.mission.path is not before
    assert BLOCKED in said


def test_speed_grows_gently(chair: GoingChair) -> None:
    speeds = []
    for _ in range(400):
        chair.step()
        speeds.append(chair.chair.speed_m_s)
    change = np.diff(speeds) / 0.05
    assert change.max() < 1.7 * ACCELERATE_M_S2


def test_who_walks_into_the_way_in_two_seconds_limits_the_speed() -> None:
    people = People()
    for k in range(12):
        x, y = 3.0, 4.0 - 0.1 * k
        around = np.array(((x, y - 0.05), (x, y), (x + 0.05, y), (x, y + 0.05)))
        people.look(around, 0.1 * k)
    assert people.tracks[0].walks
    assert people.tracks[0].vy_m_s == pytest.approx(-1.0, abs=0.3)
    path = np.array([(0.1 * k, 2.0, 0.0, 0.1 * k) for k in range(40)])
    free = people.free_m(path, Footprint())
    assert 1.0 < free < 3.0
    wide = Footprint(margins=Margins(front_m=0.5))
    assert people.free_m(path, wide) < free - 0.35
    assert math.isinf(people.free_m(path - (0.0, 3.0, 0.0, 0.0), Footprint()))


def test_parts_of_a_thing_that_come_into_view_do_not_walk() -> None:
    people = People()
    for k in range(12):
        xs = np.arange(3.0, 3.15 + 0.07 * k, 0.05)
        people.look(np.stack((xs, np.full(len(xs), 1.0)), axis=1), 0.1 * k)
    assert people.tracks[0].x_m > 3.35
    assert not people.tracks[0].walks


def test_where_it_comes_back_to_and_is_refused_again_is_as_good_as_shut(chair: GoingChair) -> None:
    # Otherwise it would turn from one path to the other and back forever.
    chair.run(2.0)
    mission, (x_m, y_m, heading) = chair.mission, chair.pose
    here, aside = (x_m, y_m, heading), (x_m, y_m, heading - 0.8)
    for pose in (here, aside, here, aside):
        mission._recovery.refused.add(pose, False, shut=False)
    assert [one.price_s for one in mission._recovery.refused.all] == [12.0, 12.0, 60.0, 60.0]
