"""Rooms: ray casting and collision, compared with cases calculated by hand."""

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazesim import chair, plans
from gazesim.rooms import Door, Person, Room, Solid, box

SQUARE = ((-5, -5, 5, -5), (5, -5, 5, 5), (5, 5, -5, 5), (-5, 5, -5, -5))
angles = st.floats(-180, 180)


def test_rays_in_a_square_room():
    room = Room("square", SQUARE)
    rays = np.radians([0.0, 90.0, 180.0, -90.0, 45.0, 30.0])
    got = room.cast(0.0, 0.0, rays, 0.25)
    wanted = [5, 5, 5, 5, 5 * math.sqrt(2), 5 / math.cos(math.pi / 6)]
    assert got == pytest.approx(wanted)


@given(angles, st.floats(-4, 4), st.floats(-4, 4))
def test_every_ray_ends_on_a_wall_of_the_square(angle_deg, x, y):
    room = Room("square", SQUARE)
    angle = math.radians(angle_deg)
    reach = float(room.cast(x, y, np.array([angle]), 0.25)[0])
    end = (x + reach * math.cos(angle), y + reach * math.sin(angle))
    assert max(abs(end[0]), abs(end[1])) == pytest.approx(5.0, abs=1e-6)


def test_a_ray_into_the_open_ends_nowhere():
    room = Room("one wall", ((2, -1, 2, 1),))
    assert room.cast(0, 0, np.array([0.0, math.pi]), 0.25).tolist() == [2.0, math.inf]


def test_a_person_is_a_disc():
    room = Room("square", SQUARE, people=(Person(((3.0, 0.0),), radius_m=0.25),))
    got = room.cast(0.0, 0.0, np.array([0.0, math.pi]), 0.25)
    assert got == pytest.approx([2.75, 5.0])


def test_a_lidar_plane_sees_a_table_by_its_legs_only():
    room = Room("table", SQUARE, (box(2, 0, 1, 1, 0.7, 0.75, "wood"),))
    assert room.cast(0, 0, np.array([0.0]), 0.25)[0] == pytest.approx(5.0)
    assert room.cast(0, 0, np.array([0.0]), 0.72)[0] == pytest.approx(1.5)
    assert room.collides(2.0 - 0.5 - chair.FRONT_M + 0.01, 0.0, 0.0)  # the chair is tall


def test_collision_is_that_of_the_rectangle():
    room = Room("square", SQUARE)
    for x, touches in ((5 - chair.FRONT_M - 0.01, False), (5 - chair.FRONT_M + 0.01, True)):
        assert room.collides(x, 0.0, 0.0) is touches
    for y, touches in ((5 - chair.HALF_WIDTH_M - 0.01, False), (5 - 0.36, True)):
        assert room.collides(0.0, y, 0.0) is touches
    assert room.collides(-5 - chair.REAR_M - 0.01, 0.0, 0.0)
    assert not room.collides(5 - chair.FRONT_M + 0.01, 0.0, 90.0)  # turned away


def test_a_thin_leg_wholly_under_the_chair_touches_too():
    room = Room("leg", SQUARE, (box(0.1, 0.1, 0.02, 0.02, 0, 0.5, "wood"),))
    assert room.collides(0.0, 0.0, 0.0)
    assert room.clearance_m(0.0, 0.0, 0.0) == 0.0


@given(angles, st.floats(-3, 3), st.floats(-3, 3))
def test_clearance_is_never_positive_in_a_collision_and_turns_with_the_chair(heading, x, y):
    room = Room("post", SQUARE, (box(0, 0, 0.3, 0.3, 0, 1, "wood"),))
    gap = room.clearance_m(x, y, heading)
    assert (gap == 0.0) == room.collides(x, y, heading)
    corners = [
        (fx, fy)
        for fx in (chair.FRONT_M, chair.REAR_M)
        for fy in (-chair.HALF_WIDTH_M, chair.HALF_WIDTH_M)
    ]
    c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    walls = min(5 - max(abs(x + c * fx - s * fy), abs(y + s * fx + c * fy)) for fx, fy in corners)
    assert gap <= walls + 1e-9


def test_clearance_of_a_wall_ahead():
    room = Room("wall", ((3, -9, 3, 9),))
    assert room.clearance_m(0, 0, 0) == pytest.approx(3 - chair.FRONT_M)
    assert room.clearance_m(0, 0, 180) == pytest.approx(3 + chair.REAR_M)


def test_a_closed_door_closes():
    room = Room("door", SQUARE, doors=(Door("hall", (2.0, 0.5), (2.0, -0.5)),))
    ray = np.array([0.0])
    assert room.cast(0, 0, ray, 0.25)[0] == pytest.approx(5.0)
    room.set_door("hall", False)
    assert room.cast(0, 0, ray, 0.25)[0] == pytest.approx(1.98)
    with pytest.raises(ValueError, match="no door 'attic'; doors: hall"):
        room.set_door("attic", True)


def test_people_walk_to_and_fro_and_wait_for_the_chair():
    person = Person(((2.0, -2.0), (2.0, 2.0)), speed_m_s=1.0)
    room = Room("walk", SQUARE, people=(person,))
    far = (-3.0, 0.0, 0.0)
    seen = []
    for _ in range(100):
        room.step(0.1, *far)
        seen.append(person.y_m)
    assert max(seen) == pytest.approx(2.0, abs=0.11)
    assert seen[-1] == pytest.approx(0.0, abs=0.3)  # 10 m on: back again, in the middle
    for _ in range(100):
        room.step(0.1, 2.0, 0.0, 90.0)  # the chair stands in the way
        assert not room.collides(2.0, 0.0, 90.0) or abs(person.y_m) < 1.0


@pytest.mark.parametrize("name", [*plans.names(), "home-3"])
def test_the_chair_fits_where_each_room_starts(name):
    room = plans.room(name)
    assert room.name == name.replace("-", " ")
    assert not room.collides(*room.start)
    around = np.linspace(-math.pi, math.pi, 2000)
    assert np.isfinite(room.cast(*room.start[:2], around, 0.25)).all()


def test_the_chair_fits_through_the_living_rooms_door():
    room = plans.room("living")
    for y in np.arange(0.6, 3.3, 0.05):
        assert not room.collides(2.1, float(y), 90.0), y
    room.set_door("hallway", False)
    assert room.collides(2.1, 2.2, 90.0)


def test_solids_are_convex_and_counter_clockwise():
    for name in plans.names():
        for solid in plans.room(name).solids():
            assert isinstance(solid, Solid)
            for k, (ax, ay) in enumerate(solid.corners):
                bx, by = solid.corners[(k + 1) % len(solid.corners)]
                cx, cy = solid.corners[(k + 2) % len(solid.corners)]
                assert (bx - ax) * (cy - by) - (by - ay) * (cx - bx) > 0


def test_an_unknown_room_is_refused_by_name():
    with pytest.raises(ValueError, match="no room 'moon'; there are living"):
        plans.room("moon")
    for name in ("home-", "home-x", "home--1"):
        with pytest.raises(ValueError, match="no room"):
            plans.room(name)


@pytest.mark.parametrize("seed", range(3))
def test_a_chair_on_its_way_touches_what_one_put_there_touches(seed):
    """Nothing is recomputed where no obstacle can have come near since the last look."""
    dice = random.Random(seed)
    x, y, heading_deg = 0.0, 0.0, dice.uniform(-180, 180)
    room, touched = plans.room("living"), 0
    room.people = room.people if seed == 0 else ()
    for step in range(400):
        x += dice.uniform(-0.02, 0.06) * math.cos(math.radians(heading_deg))
        y += dice.uniform(-0.02, 0.06) * math.sin(math.radians(heading_deg))
        heading_deg += dice.uniform(-6, 7)
        if step % 40 == 20:
            there = box(x + 1.0, y, 0.3, 0.3, 0.0, 1.0, "wood")
            room.put("box", there if dice.random() < 0.5 else None)
        room.step(0.05, x, y, heading_deg)
        fresh = replace(room, _free=None)
        assert room.collides(x, y, heading_deg) is fresh.collides(x, y, heading_deg)
        if fresh.collides(x, y, heading_deg):
            touched += 1
            x, y, heading_deg = 0.0, 0.0, dice.uniform(-180, 180)
    assert touched > 3
