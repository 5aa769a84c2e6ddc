"""Homes: rays that are exact, glass, mirrors and legs, scripts, routes, ROS maps, drives."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from gazechair.sensing.inbox.motion import Motion
from gazechair.sensing.mapping.stored.home_map import MapError
from gazesim import home_plans, home_routes, rays, ros_map
from gazesim.home_drive import FRONT, Drive
from gazesim.homes import GLASS, MIRROR, Event, Home, Walker
from gazesim.rooms import Door, box, cast_rays

ALL_ROUND = np.radians(np.arange(-180.0, 180.0, 0.5))
HALL = (
    (-4.0, -4.0, 4.0, -4.0),
    (4.0, -4.0, 4.0, 4.0),
    (4.0, 4.0, -4.0, 4.0),
    (-4.0, 4.0, -4.0, -4.0),
)


def test_rays_are_those_of_the_simple_caster_from_every_origin() -> None:
    chance = np.random.default_rng(1)
    segments = chance.uniform(-5.0, 5.0, (80, 4))
    x, y = chance.uniform(-0.1, 0.1, (2, len(ALL_ROUND)))
    found, which = rays.cast(x, y, ALL_ROUND, segments)
    nothing = np.zeros((0, 3))
    for k, angle in enumerate(ALL_ROUND):
        expected = cast_rays(x[k], y[k], np.array([angle]), segments, nothing)[0]
        assert found[k] == expected
        assert (which[k] == rays.NOTHING) == math.isinf(expected)


def test_part_of_a_turn_sees_what_a_whole_one_does() -> None:
    segments = np.random.default_rng(2).uniform(-5.0, 5.0, (40, 4))
    still = np.zeros(len(ALL_ROUND))
    whole, _ = rays.cast(still, still, ALL_ROUND, segments)
    part = slice(200, 430)
    found, _ = rays.cast(still[part], still[part], ALL_ROUND[part], segments)
    assert np.array_equal(found, whole[part])


def test_glass_returns_straight_beams_only() -> None:
    home = Home("glass", HALL, (box(2.0, 0.0, 0.02, 3.0, 0.0, 2.0, GLASS),))
    straight, slanting = home.cast(0.0, 0.0, np.radians([0.0, 20.0]), 0.25)
    assert straight == pytest.approx(1.99)
    assert slanting == pytest.approx(4.0 / math.cos(math.radians(20.0)))


def test_a_mirror_shows_the_room_behind_it() -> None:
    home = Home("mirror", HALL, (box(2.0, 0.0, 0.02, 3.0, 0.0, 2.0, MIRROR),))
    assert home.cast(0.0, 0.0, np.array([0.0]), 0.25)[0] == pytest.approx(1.99 + 5.99)


def test_a_lidar_sees_two_legs_of_a_person() -> None:
    home = Home("legs", HALL, people=(Walker(((2.0, -1.0), (2.0, 1.0))),))
    near = home.cast(0.0, -1.0, np.radians(np.arange(-10.0, 10.0, 0.1)), 0.25) < 3.0
    assert np.count_nonzero(np.diff(near.astype(int)) == 1) == 2


def test_a_person_near_the_chair_leaves_and_comes_back() -> None:
    home = Home("person", HALL, people=(Walker(((1.5, 0.0), (1.5, 1.0))),))
    away = [False] * 900
    for step in range(len(away)):
        home.walk(0.05, 0.0, 0.0, 0.0)
        away[step] = math.hypot(home.people[0].x_m, home.people[0].y_m) > 10.0
    assert not away[0]
    assert any(away)
    assert not all(away[away.index(True) :])


def test_the_script_closes_doors_and_moves_furniture_but_not_onto_the_chair() -> None:
    door = Door("door", (3.0, 0.0), (3.0, 1.0))
    stool = box(-2.0, 0.0, 0.4, 0.4, 0.0, 0.5, "wood")
    onto = box(0.2, 0.0, 0.4, 0.4, 0.0, 0.5, "wood")
    script = (Event(1.0, door="door", opens=False), Event(2.0, piece=0, solid=onto))
    home = Home("script", HALL, (stool,), (door,), script=script)
    for _ in range(100):
        home.walk(0.05, 0.0, 0.0, 0.0)
    assert not door.open
    assert home.furniture == (stool,)
    for _ in range(100):
        home.walk(0.05, 2.0, -2.0, 0.0)
    assert home.furniture == (onto,)


@pytest.mark.parametrize("seed", [2, 4])
def test_a_home_is_the_same_for_its_seed_and_connected(seed: int) -> None:
    home = home_plans.home(seed)
    assert len(home.places) >= 4
    assert home_routes.unreached(home) == set()
    assert home.furniture == home_plans.home(seed).furniture


@pytest.mark.long
def test_a_hundred_homes_are_connected() -> None:
    for seed in range(100):
        assert home_routes.unreached(home_plans.home(seed)) == set(), seed


def test_a_closed_door_cuts_a_room_off() -> None:
    home = home_plans.home(4)
    for door in home.doors:
        home.set_door(door.name, False)
    assert home_routes.unreached(home)


def test_a_drive_touches_nothing_and_the_heading_is_the_sensors() -> None:
    drive = Drive(home_plans.home(4), 4, lidars=())
    off = []
    for event in drive.events(40.0):
        assert isinstance(event, Motion)
        pose = drive.driver.pose
        assert not drive.home.collides(pose.x_m, pose.y_m, pose.heading_deg)
        assert event.heading_deg is not None
        off.append((event.heading_deg - drive.truth(event.time_s).heading_deg + 180.0) % 360.0)
    assert drive.way_m > 5.0
    turned = np.unwrap(np.radians(off))
    assert 0.0 < np.degrees(np.ptp(turned)) < 8.0


def test_a_lidar_on_a_moving_chair_measures_the_walls_where_they_are() -> None:
    drive = Drive(home_plans.home(4), 4, lidars=(FRONT,), per_turn=800)
    for event in drive.events(10.0):
        if isinstance(event, Motion) or abs(drive.driver.speeds[0]) < 0.2:
            continue
        for k in range(0, len(event.times_s), 40):
            if event.distances_m[k] == 0.0:
                continue
            at = drive.truth(float(event.times_s[k]))
            c, s = math.cos(math.radians(at.heading_deg)), math.sin(math.radians(at.heading_deg))
            x, y = at.x_m + c * FRONT.x_m, at.y_m + s * FRONT.x_m
            angle = math.radians(at.heading_deg + event.directions_deg[k])
            true_m = drive.home.cast(x, y, np.array([angle]), 0.25)[0]
            assert event.distances_m[k] == pytest.approx(true_m, abs=0.06) or true_m > 30.0
        return
    raise AssertionError("it never moved")


def _ros_map(folder: Path, grey: np.ndarray) -> Path:
    height, width = grey.shape
    head = f"P5\n# a comment\n{width} {height}\n255\n".encode()
    (folder / "map.pgm").write_bytes(head + grey.astype(np.uint8).tobytes())
    text = "image: map.pgm\nresolution: 0.05\norigin: [-5.0, -2.0, 0.0]\nnegate: 0\n"
    (folder / "map.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return folder / "map.yaml"


def test_a_ros_map_is_a_home(tmp_path: Path) -> None:
    grey = np.full((80, 160), 205)
    grey[2:-2, 2:-2] = 254
    grey[[2, -3], 2:-2] = 0
    grey[2:-2, [2, -3]] = 0
    grey[10, 30:50] = 0  # row 10 from the top
    home = ros_map.load(_ros_map(tmp_path, grey))
    # To the right wall's near side, from the map's middle.
    ahead = home.cast(-1.0, 0.0, np.array([0.0]), 0.25)[0]
    assert ahead == pytest.approx((160 - 3) * 0.05 - 5.0 + 1.0)
    up = home.cast(-5.0 + 40 * 0.05, 0.0, np.array([math.pi / 2]), 0.25)[0]
    assert up == pytest.approx((80 - 11) * 0.05 - 2.0)
    assert len(home.places) >= 2
    for x, y in home.places.values():
        assert not home.collides(x, y, 45.0)


@pytest.mark.parametrize("broken", [b"P6\n3 3\n255\n", b"P5\n9 9\n255\n..."])
def test_a_map_that_cannot_be_used_is_refused_in_one_line(tmp_path: Path, broken: bytes) -> None:
    path = _ros_map(tmp_path, np.zeros((3, 3)))
    (tmp_path / "map.pgm").write_bytes(broken)
    with pytest.raises(MapError) as refused:
        ros_map.load(path)
    assert "\n" not in str(refused.value)
