"""Two lidars are compared by a wall that both see: at rest, in a corridor, and beside a bend."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from corridorrig import BEGINS_S, Straight, corridor
from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.inbox.pieces import Piece
from gazechair.sensing.mapping.locating.looks import Looks
from gazechair.sensing.odometry.doubts import TURNED
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.odometry import Odometry
from gazechair.sensing.odometry.shared_walls import SharedWalls, straight_wall
from gazesim.home_drive import FRONT, REAR, Drive
from gazesim.home_plans import home
from gazesim.home_routes import Pose
from gazesim.homes import Home

Array = np.ndarray
AT_M = (0.5, -0.4)  # of the lidars, ahead of the axle
HALF_S, STEP_M = 0.05, 0.03


def seen(x_m: float, bend_m: float, bend_deg: float, ahead: bool, turned_deg: float) -> Array:
    """(N, 2) points of the wall to the left, chair's frame; it bends at `bend_m`."""
    along = np.arange(0.1, 3.0, 0.05) if ahead else -np.arange(0.1, 3.0, 0.05)
    at_m = AT_M[0 if ahead else 1]
    x = x_m + at_m + along
    y = 0.7 + np.tan(math.radians(bend_deg)) * np.maximum(0.0, x - bend_m)
    noise = np.random.default_rng(round(1e3 * x_m) + ahead).normal(0.0, 0.006, len(x))
    c, s = math.cos(math.radians(turned_deg)), math.sin(math.radians(turned_deg))
    return np.stack((at_m + c * along - s * (y + noise), s * along + c * (y + noise)), axis=1)


def driven(
    metres: float, turned_deg: tuple[float, float], bend: tuple[float, float] = (99.0, 0.0)
) -> SharedWalls:
    """The comparison after a drive along that wall, or after two seconds of standing."""
    walls, x_m = SharedWalls(), 0.0
    for step in range(40 + round(metres / STEP_M)):
        x_m = STEP_M * max(0, step - 40)
        for lidar, deg in enumerate(turned_deg):
            points = seen(x_m, *bend, lidar == 0, deg)
            beyond = points[:, 0] + x_m > bend[0]
            angles = np.radians(deg + bend[1] * beyond)
            normals = np.stack((np.sin(angles), -np.cos(angles)), axis=1)
            times = HALF_S * (step + np.array((0.0, 1.0)))
            piece = Piece(times, times, times, (AT_M[lidar], 0.0), 800, lidar)
            walls.take(piece, points, normals, np.array((x_m, 0.0, 0.0)))
    return walls


@pytest.mark.parametrize("which", [0, 1])
@pytest.mark.parametrize("deg", [8.0, -3.0])
def test_one_is_turned_named_and_measured_at_rest_and_sure_after_a_metre(
    which: int, deg: float
) -> None:
    turned_deg = (deg, 0.0) if which == 0 else (0.0, deg)
    found = driven(0.0, turned_deg).compared
    assert (found.turned, found.agree, found.sure) == (which, False, False)
    assert math.degrees(found.by_rad) == pytest.approx(deg, abs=0.3)
    assert driven(1.0, turned_deg).compared.sure


@pytest.mark.parametrize("deg", [0.0, 1.0, -1.0])
def test_up_to_a_degree_they_agree(deg: float) -> None:
    found = driven(2.0, (deg, 0.0)).compared
    assert (found.agree, found.turned, found.sure) == (True, None, False)


@pytest.mark.parametrize("half_ahead", [None, 0, 1])
@pytest.mark.parametrize(("bumped_deg", "agree"), [(0.0, True), (1.0, True), (3.0, False)])
def test_that_they_agreed_tells_nothing_once_one_sees_its_wall_turn(
    bumped_deg: float, agree: bool, half_ahead: int | None
) -> None:
    """The chair stands; from then on the other lidar sees the wall to the right alone.

    In one of two half turns, `half_ahead`, the bumped one sees a wall ahead instead of its own.
    """
    walls = driven(0.0, (0.0, 0.0))
    assert walls.compared.agree
    for step in range(40, 80):
        ahead_deg = -90.0 if step % 2 == half_ahead else 0.0
        for lidar, deg in enumerate((bumped_deg + ahead_deg, 0.0)):
            points = seen(0.0, 99.0, 0.0, lidar == 0, deg) * (1.0, (1.0, -1.0)[lidar])
            normal = math.sin(math.radians(deg)), -math.cos(math.radians(deg)) * (1.0, -1.0)[lidar]
            times = HALF_S * (step + np.array((0.0, 1.0)))
            piece = Piece(times, times, times, (AT_M[lidar], 0.0), 800, lidar)
            walls.take(piece, points, np.tile(normal, (len(points), 1)), np.zeros(3))
    assert walls.compared.agree is agree


@pytest.mark.parametrize("deg", [2.0, 4.0, -8.0])
def test_a_wall_with_a_bend_is_no_turned_lidar(deg: float) -> None:
    assert driven(0.0, (0.0, 0.0), (0.4, deg)).compared.turned is not None  # it seems so at rest
    for metres in np.arange(0.2, 3.4, 0.2):
        assert not driven(float(metres), (0.0, 0.0), (1.2, deg)).compared.sure
    assert driven(5.5, (0.0, 0.0), (1.2, deg)).compared.agree


def test_what_fits_turned_back_is_turned_and_what_does_not_is_a_bend() -> None:
    turned, bend, few = (driven(0.0, (5.0, 0.0)) for _ in range(3))
    for _ in range(3):
        turned.turned_back(math.radians(0.3), 0.6)
        bend.turned_back(math.radians(5.2), 0.6)
        few.turned_back(math.radians(0.3), 0.2)
    assert turned.compared.sure
    assert bend.compared.turned is None
    assert not few.compared.sure


def in_a_rough_room(turned_deg: float, seed: int) -> list[bool]:
    """Whether the first lidar seemed turned, for each half turn of 5 m along rough walls.

    Each comparison shows the walls, as that lidar sees them, 3 degrees (standard deviation) off.
    """
    walls, rough, named = SharedWalls(), np.random.default_rng(seed).normal(0.0, 3.0, 60), []
    for step in range(200):
        x_m = STEP_M * max(0, step - 40)
        for lidar, deg in enumerate((turned_deg + float(rough[int(step * HALF_S / 0.5)]), 0.0)):
            points = seen(x_m, 99.0, 0.0, lidar == 0, deg)
            normal = math.sin(math.radians(deg)), -math.cos(math.radians(deg))
            times = HALF_S * (step + np.array((0.0, 1.0)))
            piece = Piece(times, times, times, (AT_M[lidar], 0.0), 800, lidar)
            walls.take(piece, points, np.tile(normal, (len(points), 1)), np.array((x_m, 0.0, 0.0)))
        named.append(walls.compared.turned == 0)
    return named


def test_rough_walls_show_no_turned_lidar_but_one_that_is_turned_by_more_than_they_scatter() -> (
    None
):
    right = [in_a_rough_room(0.0, seed) for seed in range(12)]
    turned = [in_a_rough_room(12.0, seed) for seed in range(12)]
    assert np.mean(right) < 0.25  # 0.55 if the scatter did not count
    assert np.mean([each[100:] for each in turned]) > 0.9


def test_far_away_from_what_was_compared_nothing_is_known() -> None:
    walls = driven(0.0, (5.0, 0.0))
    times = np.array((9.0, 9.05))
    none = Piece(times, times, times, (AT_M[0], 0.0), 800, 0)
    walls.take(none, np.zeros((0, 2)), np.zeros((0, 2)), np.array((4.5, 0.0, 0.0)))
    found = walls.compared
    assert (found.agree, found.turned) == (False, None)


def test_a_straight_wall_is_found_among_other_things_and_a_short_one_is_none() -> None:
    wall = seen(0.0, 99.0, 0.0, True, 4.0)
    normals = np.tile((math.sin(math.radians(4.0)), -math.cos(math.radians(4.0))), (len(wall), 1))
    other = np.random.default_rng(1).uniform(-2.0, 2.0, (40, 2))
    beams = -other / np.hypot(other[:, 0], other[:, 1])[:, None]
    points, towards = np.concatenate((wall, other)), np.concatenate((normals, beams))
    found = straight_wall(points, towards, (0.5, 0.0))
    assert found is not None
    assert math.degrees(found[0]) == pytest.approx(-86.0, abs=0.4)
    assert straight_wall(wall[:20], normals[:20], (0.5, 0.0)) is None


def half(step: int, lidar: int, turned_deg: float) -> Piece:
    """The half turn that ends at `step`, of a chair that stands in a passage of 1.4 m."""
    own = -(np.arange(400) + 0.5) * 0.45 - step % 2 * 180.0
    angles = np.radians(own + turned_deg) % (2.0 * math.pi)
    order, metres = np.argsort(angles), np.empty(400)
    walls = ((-9.0, -0.7, 9.0, -0.7), (-9.0, 0.7, 9.0, 0.7), (9.0, -0.7, 9.0, 0.7))
    here = np.full(400, AT_M[lidar]), np.zeros(400)
    metres[order] = Home("passage", walls).cast_moving(*here, angles[order], 0.25)
    noisy = metres + np.random.default_rng(2 * step + lidar).normal(0.0, 0.006, 400)
    times = HALF_S * (step - 1 + (np.arange(400) + 0.5) / 400)
    distances = np.where(metres < 18.0, noisy, 0.0)
    directions = (own + 180.0) % 360.0 - 180.0
    return Piece(directions, distances, times, (AT_M[lidar], 0.0), 800, lidar)


def test_one_that_is_left_out_still_gets_estimates_but_no_look_shows_it() -> None:
    odometry, looks = Odometry(), Looks()
    told: list[Estimate] = []
    for step in range(1, 60):
        odometry.motion(Motion(HALF_S * step, 0.0, 0, 0))
        for lidar, deg in ((1, 0.0), (0, 6.0)):
            piece = half(step, lidar, deg)
            looks.piece(piece)
            if (found := odometry.piece(piece)) is not None:
                told.append(found)
                looks.estimate(found)
    assert [one.left_out for one in told[-10:]] == [False, True] * 5
    assert all(abs(one.x_m) + abs(one.y_m) < 0.02 for one in told)
    assert {round(float(x), 3) for x in looks.seen().look.origins_m[:, 0]} == {AT_M[1]}
    for step in range(60, 70):  # the only one that is left is used
        found = odometry.piece(half(step, 0, 6.0))
        assert found is not None
    assert not found.left_out


def along_a_corridor(turned_deg: float, which: int) -> tuple[int, float, set[int | None]]:
    """Estimates outside their claim, the way until it was told, and which lidar was named."""
    lidars, odometry = (FRONT, REAR), Odometry()
    driven = Drive(home(4), 3, lidars, per_turn=800)
    driven.home = corridor()
    straight = Straight(driven.home, Pose(0.0, 0.0, 0.0), 0.6, (800, 0), None)
    driven.driver = straight  # type: ignore[assignment]
    driven.lidars = tuple(
        replace(one, heading_deg=one.heading_deg + turned_deg * (number == which))
        for number, one in enumerate(lidars)
    )
    outside, told_m, named = 0, math.inf, set()
    for event in driven.events(6.0):
        if isinstance(event, Motion):
            permille = event.linear_permille if driven.time_s >= BEGINS_S - 0.15 else 0
            odometry.motion(replace(event, linear_permille=permille))
            continue
        if event.lidar == which:  # nobody told the host
            event = replace(event, directions_deg=event.directions_deg - turned_deg)
        if (said := odometry.piece(event)) is None:
            continue
        off_m = abs(said.x_m - driven.truth(said.time_s).x_m), abs(said.y_m)
        outside += off_m[0] > 3.0 * said.along_sigma_m + 0.05
        outside += off_m[1] > 3.0 * said.across_sigma_m + 0.05
        if TURNED in said.doubts:
            told_m = min(told_m, driven.truth(said.time_s).x_m)
            named.add(said.turned_lidar)
    return outside, told_m, named


@pytest.mark.costly
@pytest.mark.parametrize(("deg", "which"), [(8.0, 0), (-3.0, 1)])
def test_in_a_bare_corridor_one_of_two_that_is_turned_is_told_and_nothing_is_outside(
    deg: float, which: int
) -> None:
    outside, told_m, named = along_a_corridor(deg, which)
    assert outside == 0
    assert told_m < 1.2
    assert named == {which}


@pytest.mark.costly
def test_a_degree_between_two_is_not_told() -> None:
    assert along_a_corridor(1.0, 0) == (0, math.inf, set())
