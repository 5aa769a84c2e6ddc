"""Another goal on the way: what counts as new motion, and which limit counts for whom."""

from __future__ import annotations

import math
import pathlib
from dataclasses import replace
from itertools import pairwise, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gazechair.going.mission import DRIVING, PLANNING
from gazechair.going.plan import Path
from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import occupancy_of
from gazelink.settings_table import PROFILES
from gazemeasure.go.another import (
    BACKS,
    CURVES,
    GOES_ON,
    KIND,
    STARTS,
    STOPS,
    TURNS,
    Another,
    GoesOn,
    Redirected,
    add,
    class_of,
    floor_s,
    obeys,
    off_rad,
    steered_deg_s,
)
from gazemeasure.go.whole import Driven, Scene
from gazemeasure.home.localization import look
from gazemeasure.on_record import Job
from gazemeasure.report import Report
from gazesim import pot
from gazesim.chair import Chair
from gazesim.home_drive import FRONT, REAR
from gazesim.homes import Home
from gazesim.rooms import box

pytestmark = pytest.mark.costly

AHEAD = Path(np.array([(0.0, 0.0), (2.0, 0.0)]), None)
BACK = Path(np.array([(0.0, 0.0), (-1.0, 0.0), (-1.0, 2.0)]), None, backward=True)
TURN = Path(np.array([(0.0, 0.0), (0.01, 0.0)]), math.pi / 2)


def test_the_angle_is_that_of_the_first_leg_as_it_is_driven_or_of_the_last_turn() -> None:
    assert off_rad(AHEAD, 0.5) == pytest.approx(-0.5)
    assert off_rad(BACK, 0.0) == pytest.approx(0.0)
    assert off_rad(TURN, 0.0) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize(
    ("path", "off", "speed_m_s", "rate_deg_s", "new"),
    [
        (AHEAD, 0.05, 0.06, 0.0, True),
        (AHEAD, 0.05, 0.04, 9.0, False),
        (BACK, 0.0, 0.06, 0.0, False),
        (BACK, 0.0, -0.06, 0.0, True),
        (AHEAD, 0.5, 0.3, 0.0, False),  # it only rolls on along the path before
        (AHEAD, 0.5, 0.3, 2.1, True),
        (AHEAD, -0.5, 0.3, 2.1, False),
    ],
)
def test_new_motion_is_the_chairs_as_the_new_path_begins(
    path: Path, off: float, speed_m_s: float, rate_deg_s: float, new: bool
) -> None:
    assert obeys(path, off, speed_m_s, rate_deg_s) is new


@pytest.mark.parametrize(
    ("speed_m_s", "before_deg_s", "rate_deg_s", "new"),
    [
        (0.3, 4.0, 4.5, False),  # it steered along its leg
        (0.3, 4.0, 6.5, True),
        (0.3, -4.0, 2.5, True),
        (0.3, 9.0, 9.0, True),  # a turn, which goes on
        (0.0, 4.0, 4.0, True),
    ],
)
def test_what_it_steered_along_its_leg_is_no_turn_to_the_new_path(
    speed_m_s: float, before_deg_s: float, rate_deg_s: float, new: bool
) -> None:
    steered = steered_deg_s(speed_m_s, before_deg_s)
    assert obeys(AHEAD, 0.5, speed_m_s, rate_deg_s, steered) is new


FULL, NEUTRAL = 254, 170
"""Wiper counts."""


def driven(chair: Chair, wipers: tuple[int, int], seconds: float) -> None:
    linear, turn = (pot.deflection(one) for one in wipers)
    for _ in range(round(1000.0 * seconds)):
        chair.step(0.001, (linear, turn))


@pytest.mark.parametrize(
    ("before", "after", "least_m_s", "most_m_s"),
    [
        ((FULL, NEUTRAL), (FULL, NEUTRAL), -0.001, 0.001),
        ((FULL, NEUTRAL), (NEUTRAL, NEUTRAL), 0.1, 1.0),
        ((NEUTRAL, NEUTRAL), (NEUTRAL, NEUTRAL), -0.001, 0.001),  # it brakes anyway
    ],
)
def test_braking_is_what_the_chair_would_not_have_done_anyway(
    before: tuple[int, int], after: tuple[int, int], least_m_s: float, most_m_s: float
) -> None:
    chair = Chair("3.1")
    driven(chair, (NEUTRAL, NEUTRAL), 0.1)
    driven(chair, (FULL, NEUTRAL), 3.0)
    driven(chair, before, 0.3)
    goes_on = GoesOn(chair, before)
    assert goes_on.wipers == before
    for _ in range(600):
        driven(chair, after, 0.001)
        goes_on.one_ms()
    assert least_m_s < goes_on.faster_m_s(chair) < most_m_s


@pytest.mark.parametrize(
    ("path", "off", "speed_m_s", "rate_deg_s", "how"),
    [
        (AHEAD, 0.02, 0.3, 0.0, GOES_ON),
        (BACK, 0.02, -0.3, 0.0, GOES_ON),
        (AHEAD, 0.4, 0.0, 9.0, GOES_ON),
        (AHEAD, 2.0, 0.0, 9.0, GOES_ON),
        (AHEAD, 0.4, 0.3, 0.0, CURVES),
        (AHEAD, -0.4, 0.3, 0.0, CURVES),
        (AHEAD, 2.0, 0.3, 0.0, STOPS),
        (AHEAD, -0.4, 0.3, 9.0, STOPS),
        (AHEAD, -0.4, 0.0, 9.0, STOPS),
        (AHEAD, 0.4, 0.0, 0.0, TURNS),
        (AHEAD, 0.02, 0.0, 0.0, STARTS),
        (AHEAD, 0.02, 0.0, 9.0, STARTS),
        (BACK, 0.02, 0.0, 0.0, STARTS),
        (BACK, 0.0, 0.3, 0.0, BACKS),
        (AHEAD, 0.0, -0.3, 0.0, BACKS),
    ],
)
def test_what_a_path_asks_depends_on_how_the_chair_moves(
    path: Path, off: float, speed_m_s: float, rate_deg_s: float, how: str
) -> None:
    assert class_of(path, off, speed_m_s, rate_deg_s) == how


SLOW = (STARTS, STOPS, BACKS)


def done(how: str = CURVES, after_s: float = 0.4, **driven: Any) -> Redirected:
    of = Driven(**{"arrived": True, **driven})
    return Redirected(Job(KIND, 1), of, "3.1", how, after_s, min(after_s, 0.45), 0.1, 0.12)


def ok(*of: Redirected) -> bool:
    report = Report("")
    add(report, list(of))
    return report.ok


def test_half_a_second_is_the_limit_beyond_what_the_chair_alone_takes() -> None:
    assert ok(done(), done(GOES_ON), done(TURNS, 0.9), *(done(how, 1.0) for how in SLOW))
    for how in (GOES_ON, CURVES):
        assert not ok(done(), done(how, 0.6))
    for how in (TURNS, *SLOW):
        assert not ok(done(), done(how, floor_s("3.1", how) + 0.51))
        assert not ok(done(), done(how, math.inf))
    assert not ok(done(), done("", math.inf))
    assert not ok(done(), replace(done(TURNS, 0.9), responds_after_s=0.51))
    assert not ok(done(), done(collisions=1))
    assert not ok(done(), done(arrived=False))


@pytest.mark.parametrize("profile", PROFILES)
def test_the_chair_alone_takes_longer_where_it_must_stop_or_start(profile: str) -> None:
    curves, turns, starts, stops, backs = (
        floor_s(profile, how) for how in (CURVES, TURNS, STARTS, STOPS, BACKS)
    )
    assert floor_s(profile, GOES_ON) == 0.0
    assert 0.2 < curves < 0.5 < starts < backs < 1.5
    assert curves < turns < stops < 1.5


FIRST, SECOND = (9.0, 0.0, 0.0), (1.0, 5.0, 0.0)


def watched(state: str = DRIVING) -> Any:
    """A judge 0.1 s after the message, of a mission that still follows the path before."""
    mission = SimpleNamespace(goal=SECOND, path=AHEAD, _path_to=FIRST, state=state)
    judge: Any = Another.__new__(Another)
    twin = Chair("3.1")
    driven(twin, (NEUTRAL, NEUTRAL), 0.1)
    driven(twin, (FULL, NEUTRAL), 3.0)
    world = SimpleNamespace(chair=twin, wipers=(FULL, NEUTRAL))
    judge.chair = SimpleNamespace(mission=mission, world=world, now_ms=9000)
    judge.pressed_ms, judge.how, judge._goes_on = 8900, "", None
    judge._wipers = world.wipers
    judge.moves_after_s = judge.responds_after_s = math.inf
    judge.planned_after_s = judge.output_after_s = math.inf
    judge._first, judge._new, judge._moved = FIRST, None, (twin.speed_m_s, 0.0)
    return judge


def goes_on(judge: Any, wipers: tuple[int, int], seconds: float) -> None:
    """The board puts this out for so long."""
    judge.chair.world.wipers = wipers
    for _ in range(round(1000.0 * seconds)):
        driven(judge.chair.world.chair, wipers, 0.001)
        judge.chair.now_ms += 1
        judge._watch()


def test_to_brake_for_another_plan_is_a_response_and_no_new_motion() -> None:
    judge = watched(PLANNING)
    judge._watch()
    goes_on(judge, (NEUTRAL, NEUTRAL), 0.6)
    assert 0.2 < judge.responds_after_s < 0.7
    assert (judge.planned_after_s, judge.moves_after_s) == (math.inf, math.inf)


def test_a_path_and_its_first_output_may_come_in_one_millisecond() -> None:
    judge = watched()
    judge.chair.mission.path, judge.chair.mission._path_to = BACK, SECOND
    goes_on(judge, (NEUTRAL, NEUTRAL), 0.6)
    assert judge.output_after_s == judge.planned_after_s == pytest.approx(0.101)
    assert 0.2 < judge.responds_after_s < 0.7
    assert judge.moves_after_s == math.inf


def test_the_newest_path_is_judged_with_the_limit_of_its_own_class() -> None:
    judge = watched()
    aside = Path(np.array([(0.0, 0.0), (1.0, 2.0)]), None)
    judge.chair.mission.path, judge.chair.mission._path_to = aside, SECOND
    judge._watch()
    assert (judge.how, judge.moves_after_s) == (STOPS, math.inf)
    judge.chair.mission.path = AHEAD
    judge._watch()
    assert (judge.how, judge.moves_after_s) == (GOES_ON, 0.1)


def test_a_path_to_the_first_goal_that_comes_after_the_message_is_not_the_new_one() -> None:
    judge = watched()
    mission, second = judge.chair.mission, SECOND
    judge._watch()
    assert (judge.how, judge.moves_after_s) == ("", math.inf)
    mission._path_to = second
    judge._watch()
    assert (judge.how, judge.moves_after_s, judge.responds_after_s) == (GOES_ON, 0.1, 0.1)


def test_the_clock_starts_at_the_message_of_the_page(tmp_path: pathlib.Path) -> None:
    corners = ((0.0, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0), (0.0, 0.0))
    walls = tuple((*a, *b) for a, b in pairwise(corners))
    home = Home("one room", walls, (box(4.6, 0.5, 0.6, 0.8, 0.0, 1.0, "cupboard"),))
    chance, keys = np.random.default_rng(1), []
    for x, y in product((0.9, 2.0, 3.3), (1.0, 2.0, 3.0)):
        pose = np.array((x, y, chance.uniform(-3.0, 3.0)))
        seen = look(home, pose, chance, (FRONT, REAR))
        keys.append(KeyScan(pose, seen.points_m, seen.origins_m, 0.0, 0.0, 0.0))
    start, goal, before = (0.9, 2.0, 0.0), (3.6, 2.9, 0.0), (3.8, 1.9, 0.0)
    scene = Scene(home, occupancy_of(keys), start, goal, "3.1")
    judge = Another(scene, before, tmp_path)
    try:
        driven = judge.drive()
    finally:
        judge.chair.close()
    assert driven.arrived, driven.why
    assert judge.how
    assert 0.1 < judge.moves_after_s < 2.0
    assert 0.0 < judge.planned_after_s <= judge.responds_after_s <= judge.moves_after_s
