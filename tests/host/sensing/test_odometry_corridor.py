"""A bare corridor tells nothing along itself, nor does what alone moves in it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from corridorrig import BEGINS_S, Straight, corridor, with_doors
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.odometry.apart import Constraints
from gazechair.sensing.odometry.doubts import CORRIDOR, PUSHED, STUCK, TURNED
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.match import FORWARD, STATES, X, Y
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.points import stand_alone
from gazechair.sensing.odometry.speed_by_command import SpeedByCommand
from gazechair.sensing.odometry.straight import as_seen, main_direction, straightened
from gazechair.sensing.odometry.surfaces import since_seen
from gazesim import home_plans
from gazesim.home_drive import FRONT, REAR, Drive, Mounted
from gazesim.home_routes import Pose
from gazesim.homes import Home
from gazesim.rooms import box


def drive(
    home: Home,
    lidars: tuple[Mounted, ...],
    seconds: float,
    speed_m_s: float = 0.0,
    bed_m_s: float | None = None,
    per_turn: int = 1600,
) -> list[tuple[Estimate, float]]:
    """The estimates, and how far each is off along the corridor."""
    driven = Drive(home_plans.home(4), 3, lidars, per_turn)
    driven.home = home
    permille = (round(math.copysign(800, speed_m_s)) if speed_m_s else 0, 0)
    pose = Pose(0.0, 0.0, 0.0)
    straight = Straight(home, pose, speed_m_s, permille, bed_m_s)
    driven.driver = straight  # type: ignore[assignment]
    odometry, found = Odometry(), []
    for event in driven.events(seconds):
        if isinstance(event, Motion):
            permille = event.linear_permille if driven.time_s >= BEGINS_S - 0.15 else 0
            odometry.motion(replace(event, linear_permille=permille))
        elif (estimate := odometry.piece(event)) is not None:
            found.append((estimate, estimate.x_m - driven.truth(estimate.time_s).x_m))
    return found


@pytest.mark.parametrize("lidars", [(FRONT, REAR), (FRONT,)], ids=["two lidars", "one"])
def test_in_a_bare_corridor_it_never_claims_more_than_it_knows(lidars: tuple[Mounted, ...]) -> None:
    found = drive(corridor(), lidars, 7.0, speed_m_s=0.6)  # by its first guess it would be 0.4
    assert all(abs(off_m) < 3.0 * one.along_sigma_m + 0.05 for one, off_m in found)
    assert abs(found[-1][1]) > 0.5
    assert sum(CORRIDOR in one.doubts for one, _ in found) > 0.9 * len(found)
    assert found[-1][0].across_sigma_m < 0.05


def test_in_a_bare_corridor_the_heading_drifts_and_is_claimed_as_sure_as_it_is() -> None:
    found = [one for one, _ in drive(corridor(), (FRONT,), 20.0, speed_m_s=0.6, per_turn=800)]
    off_deg = [abs(one.heading_deg - found[0].heading_deg) for one in found]
    sigmas_deg = [one.heading_sigma_deg for one in found]
    assert all(off < 3.0 * sigma for off, sigma in zip(off_deg, sigmas_deg, strict=True))
    assert max(off_deg) > sigmas_deg[0]  # nor would it be within the claim of standing
    assert max(sigmas_deg) < 0.5


def test_a_bed_that_leaves_does_not_take_the_chair_with_it() -> None:
    found = drive(corridor(), (FRONT,), 6.0, bed_m_s=0.5)
    assert max(abs(off_m) for _, off_m in found) < 0.02
    assert not any(PUSHED in one.doubts for one, _ in found)


def test_behind_a_bed_that_leads_it_knows_the_way_by_its_command_alone() -> None:
    found = drive(corridor(), (FRONT,), 7.0, speed_m_s=0.4, bed_m_s=0.6)
    assert all(abs(off_m) < 3.0 * one.along_sigma_m + 0.05 for one, off_m in found)
    assert abs(found[-1][1]) < 0.15
    assert not any(PUSHED in one.doubts for one, _ in found)


def test_two_cupboards_apart_tell_the_place_along_a_corridor() -> None:
    cupboards = [box(x, 0.6, 0.5, 0.3, 0.0, 1.8, "cupboard") for x in (2.5, 6.5)]
    found = drive(corridor(*cupboards), (FRONT,), 5.0, speed_m_s=0.6)
    assert max(abs(off_m) for _, off_m in found) < 0.05
    assert found[-1][0].along_sigma_m < 0.12


@pytest.mark.parametrize(("first_m", "most_m"), [(-28.3, 0.1), (-28.35, 0.5)])
def test_a_rear_lidar_alone_between_doors_does_not_take_the_chair_for_standing(
    first_m: float, most_m: float
) -> None:
    doors = with_doors(first_m, 4.0)
    found = drive(doors, (REAR,), 7.0, speed_m_s=0.6, per_turn=800)
    assert all(abs(off_m) < 3.0 * one.along_sigma_m + 0.05 for one, off_m in found)
    assert max(abs(off_m) for _, off_m in found) < most_m
    assert not any({STUCK, PUSHED} & set(one.doubts) for one, _ in found)


@pytest.mark.parametrize(("first_m", "per_turn"), [(-1.2, 1600), (-0.9, 1600), (-0.8, 800)])
def test_from_a_bare_corridor_to_its_first_doors_it_never_claims_more_than_it_knows(
    first_m: float, per_turn: int
) -> None:
    found = drive(with_doors(first_m, 2.5), (REAR,), 7.0, speed_m_s=0.6, per_turn=per_turn)
    assert all(abs(off_m) < 3.0 * one.along_sigma_m + 0.05 for one, off_m in found)


@pytest.mark.parametrize(("first_m", "every_m"), [(2.0, 4.0), (2.8, 2.5), (2.3, 2.5)])
def test_a_quick_chair_at_its_first_doors_never_claims_more_than_it_knows(
    first_m: float, every_m: float
) -> None:
    found = drive(with_doors(first_m, every_m), (FRONT,), 9.0, speed_m_s=0.84, per_turn=800)
    assert all(abs(off_m) < 3.0 * one.along_sigma_m + 0.05 for one, off_m in found)
    assert not any(TURNED in one.doubts for one, _ in found)


def test_far_walls_that_few_beams_meet_do_not_take_the_chair_for_standing() -> None:
    doors = with_doors(-27.84, 12.0)
    found = drive(doors, (REAR,), 6.0, speed_m_s=-0.6, per_turn=800)
    assert all(abs(off_m) < 3.0 * one.along_sigma_m + 0.05 for one, off_m in found)
    assert not any({STUCK, PUSHED} & set(one.doubts) for one, _ in found)


def surfaces(*parts: tuple[float, float, float]) -> Constraints:
    """A corridor's walls along x; parts that face along x: at x, y, that wide."""
    along = np.arange(-6.0, 6.0, 0.1)
    walls = [np.stack((along, np.full_like(along, y)), axis=1) for y in (-0.7, 0.7)]
    ends = [
        np.stack((np.full(20, x), y + wide * np.linspace(-0.5, 0.5, 20)), axis=1)
        for x, y, wide in parts
    ]
    places = np.concatenate((*walls, *ends))
    rows = np.zeros_like(places)
    rows[: 2 * len(along), 1] = rows[2 * len(along) :, 0] = 1.0
    return Constraints(rows, places, np.full(len(places), 1000.0))


@pytest.mark.parametrize(
    ("parts", "is_open"),
    [
        ((), True),
        (((3.0, 0.0, 1.1),), True),  # a bed
        (((3.0, 0.0, 1.1), (5.1, 0.0, 0.8)), True),  # and both of its ends
        (((3.0, 0.0, 0.3), (6.5, 0.2, 0.3)), False),
        (((3.0, 0.0, 1.5),), False),  # the corridor's end
    ],
)
def test_one_thing_that_may_move_leaves_a_corridor_open(
    parts: tuple[tuple[float, float, float], ...], is_open: bool
) -> None:
    axes = surfaces(*parts).open_axes()
    assert len(axes) == is_open
    assert all(abs(axis[0]) > 0.999 for axis in axes)


def test_surfaces_that_may_be_the_wall_get_its_direction_and_others_keep_theirs() -> None:
    chance = np.random.default_rng(1)
    wall = math.pi - 0.01 + chance.normal(0.0, 0.02, 200)  # half a turn on is the same direction
    angles = np.concatenate((wall % math.pi, (0.6, 1.57)))
    off = np.full(len(angles), 0.1)
    found = straightened(angles, off, main_direction(angles, np.ones(len(angles))))
    assert np.ptp(np.sin(2.0 * found[:200])) < 1e-9
    assert found[0] % math.pi == pytest.approx(math.pi - 0.01, abs=0.005)
    assert found[200:].tolist() == angles[200:].tolist()
    assert len(straightened(angles[:0], off[:0], main_direction(angles[:0], off[:0]))) == 0


@pytest.mark.parametrize(
    ("own_deg", "seen_deg", "by_several", "found_deg"),
    [
        (47.0, 90.0, False, 90.0),  # a corner, passed by the wall
        (47.0, 130.0, False, 90.0),
        (47.0, 80.0, False, 80.0),
        (80.0, 47.0, False, 80.0),
        (47.0, math.nan, True, 90.0),
        (10.0, math.nan, True, 10.0),  # a door's side
        (10.0, math.nan, False, 90.0),  # what one beam shows
        (2.0, -1.0, False, 2.0),  # the end of the corridor, seen from either side
        (-88.0, 0.0, False, -88.0),
    ],
)
def test_no_surface_is_farther_off_the_wall_than_what_is_seen_there(
    own_deg: float, seen_deg: float, by_several: bool, found_deg: float
) -> None:
    for main_deg in (90.0, -90.0):  # the other face
        own, seen = np.radians([own_deg]), np.radians([seen_deg])
        several = np.array([by_several])
        found = math.degrees(as_seen(own, seen, several, math.radians(main_deg))[0])
        assert found % 180.0 == pytest.approx(found_deg % 180.0, abs=1e-6)


def test_far_points_of_a_wall_are_in_line_and_a_post_stands_alone() -> None:
    wall = [(x, 0.8) for x in (0.3, 0.4, 0.5, 0.6, 0.75, 1.0, 1.5, 2.2, 3.2, 4.6)]
    assert not stand_alone(np.array(wall)).any()
    post = (2.9, 0.3)
    assert stand_alone(np.array([*wall[:8], post, *wall[8:]])).nonzero()[0].tolist() == [8]


def test_surfaces_that_end_an_open_direction_tell_the_way_since_they_were_seen() -> None:
    """The speed is 0.2 m/s unsure: so is the position, by as much each second."""
    covariance = np.diag(np.full(STATES, 1e-6))
    way = np.zeros(STATES)
    way[[X, FORWARD]] = 0.2 * 2.0, 0.2
    covariance += np.outer(way, way)
    along = np.array((1.0, 0.0))
    since = since_seen(covariance, along, along)
    assert math.sqrt(since[X, X]) == pytest.approx(0.08, rel=0.1)
    assert since[X, FORWARD] == pytest.approx(0.016, rel=0.1)
    assert since[FORWARD, FORWARD] == pytest.approx(0.04, rel=0.1)
    assert since[Y, Y] == covariance[Y, Y]


def test_a_surprise_ends_where_the_speed_is_not_seen() -> None:
    speed = SpeedByCommand()
    for _ in range(10):
        speed.predict(0.0, 0.5, 0.01, 1.0, False, 0.05)
        speed.judge(0.0, 0.05)  # it is held
    assert speed.predict(0.0, 0.5, 0.01, 1.0, False, 0.05).speed_m_s == 0.0
    for _ in range(20):
        speed.judge(None, 0.05)
    assert speed.predict(0.0, 0.5, 0.01, 1.0, False, 0.05).speed_m_s > 0.0


@pytest.mark.parametrize(
    ("speed_m_s", "sigma_m_s", "changing", "learns"),
    [
        (0.3, 0.25, True, False),  # a quicker chair would be no faster yet
        (0.3, 0.25, False, True),
        (0.4, 0.02, True, True),
        (0.5, 0.25, True, False),  # it may still slow down
    ],
)
def test_a_chair_that_gains_speed_does_not_tell_how_fast_it_is_at_full_command(
    speed_m_s: float, sigma_m_s: float, changing: bool, learns: bool
) -> None:
    change = SpeedByCommand().predict(speed_m_s, 0.5, sigma_m_s, 0.8, changing, 0.05)
    assert change.learns == learns


def test_the_speed_forward_tells_less_of_that_backward() -> None:
    speed = SpeedByCommand()

    def less_sure(command: float) -> float:
        return speed.predict(0.0, 0.5, 0.05, command, True, 0.05).full_variance

    for command in (0.0, 0.8, 0.0):
        assert less_sure(command) == 0.0
        speed.judge(0.0, 0.05)
    assert math.sqrt(less_sure(-0.8)) == pytest.approx(0.075)
    assert less_sure(-0.8) > 0.0  # a step is predicted twice
    speed.judge(0.0, 0.05)
    assert less_sure(-0.8) == 0.0
