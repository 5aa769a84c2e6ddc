"""A lidar turned on its mount is detected; similar effects are distinguished by driving."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from gazechair.sensing.mapping.building.mapper import KeyScan
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid, occupancy_of
from gazechair.sensing.mapping.locating.atlas import Atlas
from gazechair.sensing.mapping.locating.localization import Localization
from gazechair.sensing.mapping.locating.looks import Seen
from gazechair.sensing.mapping.locating.map_match import Look
from gazechair.sensing.odometry.estimate import Estimate
from gazechair.sensing.odometry.mounting import Mounting, Stand
from homerig import flat, points, poses, scan

FRONT, REAR = 0, 1
STANDS = Stand(0.0, FRONT, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.95, True)
STEP_S = 0.05


def straight(mounting: Mounting, metres: float, seems_deg: float, begin: Stand = STANDS) -> Stand:
    """Drive at 0.4 m/s; the chair seems to move at that angle to the left of its heading."""
    c, s = math.cos(math.radians(seems_deg)), math.sin(math.radians(seems_deg))
    stand, step_m = begin, 0.4 * STEP_S
    for _ in range(round(metres / step_m)):
        stand = replace(
            stand,
            time_s=stand.time_s + STEP_S,
            x_m=stand.x_m + c * step_m,
            y_m=stand.y_m + s * step_m,
        )
        mounting.judge(stand)
    return stand


@pytest.mark.parametrize(
    ("seems_deg", "within_m"), [(15.0, 0.3), (-8.0, 0.3), (5.0, 0.5), (-3.0, 0.7), (2.0, 1.5)]
)
def test_who_always_seems_to_slip_sideways_has_a_turned_lidar(
    seems_deg: float, within_m: float
) -> None:
    mounting = Mounting()
    straight(mounting, within_m, seems_deg)
    assert mounting.turned
    assert not mounting.known


def test_slips_do_not_count_where_the_place_along_a_corridor_is_not_known() -> None:
    mounting = Mounting()
    stand = straight(mounting, 1.0, 5.0, replace(STANDS, ahead_sigma_m=0.3))
    assert not mounting.turned
    assert not mounting.known
    straight(mounting, 0.5, 5.0, replace(stand, ahead_sigma_m=0.1))
    assert mounting.turned


@pytest.mark.parametrize("seems_deg", [0.0, 1.0, -1.0])
def test_a_mounting_as_configured_within_a_degree_is_known_after_half_a_metre(
    seems_deg: float,
) -> None:
    mounting = Mounting()
    stand = straight(mounting, 0.4, seems_deg)
    assert math.degrees(mounting.sigma_rad) == pytest.approx(5.5)
    stand = straight(mounting, 0.2, seems_deg, stand)
    assert math.degrees(mounting.sigma_rad) == pytest.approx(1.0)
    straight(mounting, 20.0, seems_deg, stand)
    assert mounting.known
    assert not mounting.turned


def test_nothing_is_known_of_a_mounting_by_standing_by_turning_or_where_no_surface_tells_it() -> (
    None
):
    mounting = Mounting()
    for step in range(200):
        yaw_deg_s = 20.0 if step > 100 else 0.0
        mounting.judge(replace(STANDS, time_s=STEP_S * step, yaw_deg_s=yaw_deg_s))
    assert not mounting.known
    blind = replace(STANDS, time_s=20.0, sees_aside=False)
    straight(mounting, 2.0, 0.0, blind)
    assert not mounting.known


def test_it_is_not_known_any_more_after_nothing_was_seen() -> None:
    mounting = Mounting()
    stand = straight(mounting, 1.0, 0.0)
    assert mounting.known
    mounting.judge(replace(stand, time_s=stand.time_s + 2.0))
    assert not mounting.known


def test_who_is_pushed_aside_once_has_no_turned_lidar() -> None:
    mounting = Mounting()
    stand = straight(mounting, 1.0, 0.0)
    straight(mounting, 2.0, 0.0, replace(stand, y_m=stand.y_m + 0.04))
    assert not mounting.turned


def test_of_two_lidars_the_one_that_fits_worse_is_named() -> None:
    mounting = Mounting()
    for step in range(20):
        mounting.judge(replace(STANDS, time_s=STEP_S * step, lidar=(FRONT, REAR)[step % 2]))
    worse = {"matched": 0.7, "error_rad": math.radians(0.5)}
    for step in range(20, 60):
        stand = replace(STANDS, time_s=STEP_S * step, lidar=(FRONT, REAR)[step % 2])
        mounting.judge(replace(stand, **worse) if stand.lidar == REAR else stand)
    assert mounting.turned
    assert mounting.lidar == REAR


def test_what_the_lidars_see_turn_and_the_sensor_does_not_is_suspected_until_it_drives() -> None:
    for piece_deg, lately_deg in ((3.0, 0.9), (0.3, 0.5)):
        mounting = Mounting()
        mounting.judge(STANDS)
        off = {"error_rad": math.radians(piece_deg), "off_deg": lately_deg}
        assert mounting.judge(replace(STANDS, time_s=STEP_S, **off))
        stand = replace(STANDS, time_s=2.0)
        assert mounting.judge(stand)
        stand = straight(mounting, 1.6, 0.0, stand)
        assert mounting.turned
        straight(mounting, 0.8, 0.0, stand)
        assert not mounting.turned


def test_what_is_suspected_while_it_turns_is_cleared_by_turning_and_by_driving() -> None:
    mounting = Mounting()
    turning = replace(STANDS, yaw_deg_s=30.0)
    assert not mounting.judge(turning)
    assert mounting.judge(replace(turning, time_s=STEP_S, matched=0.3, old_or_turned=True))
    stand = straight(mounting, 4.4, 0.0, replace(STANDS, time_s=2.0))
    assert mounting.turned  # scans that are late, too, show no slip straight on
    for step in range(1, 30):
        mounting.judge(replace(stand, time_s=stand.time_s + STEP_S * step, yaw_deg_s=30.0))
    assert mounting.turned
    straight(mounting, 2.4, 0.0, replace(stand, time_s=stand.time_s + 2.0))
    assert not mounting.turned


@pytest.mark.parametrize(
    ("deg_s", "yaw_deg_s", "turned"), [(0.1, 0.0, True), (0.01, 0.0, False), (0.2, 20.0, False)]
)
def test_odometry_that_follows_a_turned_lidar_little_by_little_is_noticed(
    deg_s: float, yaw_deg_s: float, turned: bool
) -> None:
    mounting = Mounting()
    for step in range(400):
        at_s = STEP_S * step
        stand = replace(STANDS, time_s=at_s, offset_deg=40.0 + deg_s * at_s, yaw_deg_s=yaw_deg_s)
        mounting.judge(stand)
    assert mounting.turned is turned


def test_a_heading_that_jumps_far_is_the_sensors_fault() -> None:
    mounting = Mounting()
    for step in range(60):
        off_deg = 40.0 * math.exp(-0.1 * step)
        stand = replace(STANDS, time_s=STEP_S * step, off_deg=off_deg, offset_deg=off_deg - 40.0)
        assert not mounting.judge(stand)


def test_a_sensors_scale_is_none_and_neither_is_a_crowd_or_a_heading_that_is_missing() -> None:
    mounting = Mounting()
    for step in range(60):
        lately = 0.9 * (1.0 - math.exp(-STEP_S * step))
        turning = replace(STANDS, time_s=STEP_S * step, yaw_deg_s=40.0, off_deg=lately)
        assert not mounting.judge(turning)
    for less in ({"matched": 0.3}, {"known": False}):
        far = replace(STANDS, time_s=9.0, off_deg=3.0, error_rad=0.05)
        assert not Mounting().judge(replace(far, **less))  # type: ignore[arg-type]


def test_two_lidars_that_see_different_headings_are_not_both_right() -> None:
    mounting = Mounting()
    noticed = math.inf
    for step in range(120):
        lidar, error_deg = ((FRONT, 0.25), (REAR, -0.15))[step % 2]
        at_s = 0.025 * step
        stand = replace(STANDS, time_s=at_s, lidar=lidar, error_rad=math.radians(error_deg))
        if mounting.judge(stand):
            noticed = min(noticed, at_s)
    assert 0.5 <= noticed < 2.0
    straight(mounting, 2.4, 0.0, replace(STANDS, time_s=3.0))
    assert not mounting.turned


@pytest.fixture(scope="module")
def grid() -> OccupancyGrid:
    chance, keys = np.random.default_rng(3), []
    for pose in list(poses())[::3]:
        seen = points(*scan(flat(), pose, chance))
        keys.append(KeyScan(pose, seen, np.zeros_like(seen), 0.0, 0.0, 0.0))
    return occupancy_of(keys)


def seen_from(pose: np.ndarray, odometry: np.ndarray, at_s: float, *doubts: str) -> Seen:
    ends = points(*scan(flat(), pose, np.random.default_rng(5)))
    known = Estimate(at_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 0.1, 0.1, 0.1, 1.0, doubts, 0)
    return Seen(Look(ends, np.zeros_like(ends)), odometry, known)


def test_no_place_counts_while_a_lidar_may_be_turned(grid: OccupancyGrid) -> None:
    atlas, here = Atlas(), np.array((2.0, 1.8, 0.7))
    atlas.know({"a": grid})
    atlas.place("a", here, np.zeros(3), 0)
    assert atlas.look(seen_from(here, np.zeros(3), 0.0)) is not None
    assert atlas.look(seen_from(here, np.zeros(3), 0.2, "lidar_turned")) is None
    assert atlas.id == ""


def test_a_pose_is_as_sure_as_it_is_known_how_the_lidars_sit(grid: OccupancyGrid) -> None:
    atlas, here = Atlas(), np.array((2.0, 1.8, 0.7))
    atlas.know({"a": grid})
    atlas.place("a", here, np.zeros(3), 0)
    sigmas = {}
    for at_s, deg in ((0.0, 0.0), (0.2, 5.0)):
        seen = seen_from(here, np.zeros(3), at_s)
        ahead = Look(seen.look.points_m, np.tile((0.5, 0.0), (len(seen.look.points_m), 1)))
        estimate = replace(seen.estimate, mounting_sigma_deg=deg)
        found = atlas.look(replace(seen, look=ahead, estimate=estimate))
        assert found is not None
        told = atlas.location
        assert told is not None
        assert np.array_equal(found.pose, told.pose)
        assert (found.sigma_m, found.sigma_rad) == (told.sigma_m, told.sigma_rad)
        sigmas[deg] = found.sigma_m, math.degrees(found.sigma_rad)
        parts = 0.5 * math.radians(deg), math.radians(deg)
        assert (found.mounting_m, found.mounting_rad) == pytest.approx(parts)
        assert atlas.sure is (deg == 0.0)  # else the map is not changed by what it sees
    assert sigmas[0.0][1] < 1.0
    assert sigmas[5.0][1] == pytest.approx(math.hypot(5.0, sigmas[0.0][1]), abs=0.1)
    turned_m = 0.5 * math.radians(5.0)
    assert sigmas[5.0][0] == pytest.approx(math.hypot(turned_m, sigmas[0.0][0]), abs=0.005)


def test_a_map_that_turns_under_the_chair_at_once_is_no_turn_of_the_chair(
    grid: OccupancyGrid,
) -> None:
    here, standing = np.array((2.0, 1.8, 0.7)), np.zeros(3)
    askew = here + np.array((0.0, 0.0, math.radians(3.0)))
    atlas = Atlas()
    atlas.know({"a": grid})
    atlas.place("a", here, standing, 0)
    for number in range(5):
        assert atlas.look(seen_from(here, standing, 0.2 * number)) is not None
    assert atlas.look(seen_from(askew, standing, 1.0)) is None
    assert atlas.askew
    away = np.array((3.9, 0.0, 0.0))
    for number in range(12):  # nor is a place looked for, until it has driven a while
        assert atlas.look(seen_from(askew, away, 2.0 + 0.6 * number)) is None
    assert atlas.askew
    atlas.look(seen_from(here, away + np.array((0.2, 0.0, 0.0)), 12.0))
    assert not atlas.askew


def test_a_first_look_that_sets_a_rough_place_right_is_none(grid: OccupancyGrid) -> None:
    here, standing = np.array((2.0, 1.8, 0.7)), np.zeros(3)
    localization = Localization(grid)
    localization.place(here + np.array((0.02, 0.0, math.radians(1.8))), standing)
    for number in range(4):
        seen = seen_from(here, standing, 0.2 * number)
        assert localization.look(seen.look, standing, 0.2 * number) is not None
        assert not localization.askew


def test_what_odometry_is_off_in_turns_is_no_lidar_that_is_turned(grid: OccupancyGrid) -> None:
    here = np.array((2.0, 1.8, 0.7))
    localization = Localization(grid)
    localization.place(here, np.zeros(3))
    for number in range(8):
        true, said = (np.array((0.0, 0.0, math.radians(deg * number))) for deg in (22.5, 21.8))
        seen = seen_from(here + true, said, 0.8 * number)
        assert localization.look(seen.look, said, 0.8 * number) is not None
        assert not localization.askew
