"""Contacts of the footprint along each motion, compared with a polygon moved step by step."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from gazechair.base.footprint import Footprint, Margins, distance_m, inside
from gazechair.sensing.clearance.sweeps import (
    BEND_PER_M,
    HEADING_TOLERANCE_DEG,
    RANGE_M,
    Sweeps,
)
from gazelink import codes

F, B, L, R = codes.DIR_FORWARD, codes.DIR_BACKWARD, codes.DIR_LEFT, codes.DIR_RIGHT
BARE = Margins(0.0, 0.0, 0.0)
CHAIR = Footprint()
# A chair with foot rests, wheels that stand out and a gap between them.
FORKED = Footprint(
    [
        (0.7, 0.15),
        (0.7, 0.3),
        (0.3, 0.3),
        (0.2, 0.4),
        (-0.5, 0.35),
        (-0.5, -0.35),
        (0.2, -0.4),
        (0.7, -0.3),
        (0.7, -0.15),
        (0.4, -0.1),
        (0.4, 0.1),
    ]
)
STEP_M, STEP_DEG = 0.001, 0.1


def contact(footprint: Footprint, x: float, y: float, direction: int) -> float:
    return float(Sweeps(footprint).contacts(np.array([[x, y]]))[0, direction])


def moved(x: float, y: float, direction: int, ways: np.ndarray, heading_deg: float) -> np.ndarray:
    """Where a fixed point is, seen from the chair, after each of `ways` of the motion."""
    if direction in (F, B):
        angle = math.radians(heading_deg)
        sign = 1.0 if direction == F else -1.0
        return np.column_stack(
            (x - sign * ways * math.cos(angle), y - sign * ways * math.sin(angle))
        )
    angles = -np.radians(ways) if direction == L else np.radians(ways)
    c, s = np.cos(angles), np.sin(angles)
    return np.column_stack((c * x - s * y, s * x + c * y))


def headings(footprint: Footprint, x: float, direction: int) -> tuple[float, ...]:
    """The real path may point off for what lies ahead."""
    front = max(float(part[:, 0].max()) for part in footprint.parts)
    rear = min(float(part[:, 0].min()) for part in footprint.parts)
    if (direction == F and x > front) or (direction == B and x < rear):
        return (-HEADING_TOLERANCE_DEG, 0.0, HEADING_TOLERANCE_DEG)
    return (0.0,)


def by_steps(footprint: Footprint, x: float, y: float, direction: int) -> float:
    """The reference: the chair moves a millimetre or a tenth of a degree at a time."""
    straight = direction in (F, B)
    ways = np.arange(0.0, RANGE_M, STEP_M) if straight else np.arange(0.0, 360.0, STEP_DEG)
    found = math.inf
    for heading_deg in headings(footprint, x, direction):
        hits = np.flatnonzero(footprint.contains(moved(x, y, direction, ways, heading_deg)))
        if len(hits):
            found = min(found, float(ways[hits[0]]))
    return found


places = st.tuples(st.floats(-2.0, 2.0), st.floats(-2.0, 2.0))


@pytest.mark.parametrize("footprint", [CHAIR, FORKED], ids=["box", "forked"])
@given(place=places, direction=st.sampled_from([F, B, L, R]))
@settings(max_examples=80, deadline=None)
def test_a_point_outside_is_touched_where_the_moved_polygon_meets_it(
    footprint: Footprint, place: tuple[float, float], direction: int
) -> None:
    x, y = place
    assume(not footprint.contains(np.array([[x, y]]))[0])
    exact, stepped = contact(footprint, x, y, direction), by_steps(footprint, x, y, direction)
    # A corner that is only grazed for less than a step is seen by the exact one alone.
    step = STEP_M if direction in (F, B) else STEP_DEG
    assert exact <= stepped + 1e-6
    if exact < stepped - step - 1e-6:
        ways = exact + np.linspace(0.0, step, 40)
        grazed = Footprint(footprint.body, Margins(0.051, 0.021, 0.051))
        every = headings(footprint, x, direction)
        touching = [footprint.contains(moved(x, y, direction, ways, h)) for h in every]
        near = [grazed.contains(moved(x, y, direction, ways, h)) for h in every]
        assert np.any(touching) or np.any(near)


def back_along_bend(x: float, y: float, side: float, ways: np.ndarray) -> np.ndarray:
    """Where a fixed point is, seen from a chair after each of `ways` back along a bend."""
    angles = -side * BEND_PER_M * ways  # the chair's heading
    # The chair is on a circle whose middle is at its side.
    chair_x = np.sin(angles) * side / BEND_PER_M
    chair_y = (1.0 - np.cos(angles)) * side / BEND_PER_M
    c, s = np.cos(angles), np.sin(angles)
    dx, dy = x - chair_x, y - chair_y
    return np.column_stack((c * dx + s * dy, c * dy - s * dx))


@pytest.mark.parametrize("footprint", [CHAIR, FORKED], ids=["box", "forked"])
@given(
    place=st.tuples(st.floats(-1.5, 1.5), st.floats(-0.6, 0.6)),
    range_m=st.floats(0.1, 1.5),
)
@settings(max_examples=80, deadline=None)
def test_a_path_that_bends_backward_takes_the_body_there(
    footprint: Footprint, place: tuple[float, float], range_m: float
) -> None:
    x, y = place
    here = np.array([[x, y]])
    gap_m = float(distance_m(footprint.body, here)[0])
    assume(not inside(footprint.body, here)[0] and gap_m > 0.002)
    found = float(Sweeps(footprint).bent(here, range_m)[0])
    ways = np.arange(0.0, range_m, STEP_M)
    nearer = y - float(np.sign(y)) * min(0.01, gap_m - 0.001)
    touches = np.logical_or(
        *(inside(footprint.body, back_along_bend(x, nearer, s, ways)) for s in (1.0, -1.0))
    )
    stepped = float(ways[touches.argmax()]) if touches.any() else math.inf
    assert found <= stepped + 1e-6
    if found < stepped - STEP_M - 1e-6:  # only grazed: near the outline there
        at = [back_along_bend(x, nearer, s, np.array([found])) for s in (1.0, -1.0)]
        assert min(distance_m(footprint.body, place)[0] for place in at) < 1e-4
    assert math.isinf(found) or found <= range_m


def test_a_path_that_bends_backward_in_figures() -> None:
    sweeps = Sweeps(CHAIR)
    # 3 cm beside, 0.4 m ahead of the axle; 1 cm of it may be less: 0.02 m / (0.2 per m * 0.4 m).
    assert sweeps.bent(np.array([[0.40, 0.405]]), 1.0)[0] == pytest.approx(0.25, abs=0.06)
    assert sweeps.bent(np.array([[0.40, -0.405]]), 1.0)[0] == pytest.approx(0.25, abs=0.06)
    assert np.isinf(sweeps.bent(np.array([[0.64, 0.40]]), 1.0))  # the corner is past it soon
    # Beside the axle nothing swings yet; a wall 15 cm beside is reached after a metre.
    assert np.isinf(sweeps.bent(np.array([[0.0, 0.40]]), 0.2))
    wall = np.column_stack((np.linspace(-3, 3, 601), np.full(601, 0.525)))
    assert np.isinf(sweeps.bent(wall, 0.8)).all()
    assert sweeps.bent(wall, 1.5).min() < 1.3


@given(place=places, direction=st.sampled_from([F, B, L, R]))
@settings(max_examples=80, deadline=None)
def test_left_and_right_are_mirror_images(place: tuple[float, float], direction: int) -> None:
    x, y = place
    outlines = (CHAIR.body, CHAIR.parts[0])
    assume(min(distance_m(o, np.array([[x, y]]))[0] for o in outlines) > 1e-6)
    mirrored = {F: F, B: B, L: R, R: L}[direction]
    here, there = contact(CHAIR, x, y, direction), contact(CHAIR, x, -y, mirrored)
    assert here == pytest.approx(there, abs=1e-6)


@given(st.lists(places, min_size=1, max_size=30), st.lists(places, min_size=0, max_size=30))
@settings(max_examples=50, deadline=None)
def test_more_points_never_leave_more_room(
    some: list[tuple[float, float]], more: list[tuple[float, float]]
) -> None:
    sweeps = Sweeps(FORKED)
    few = sweeps.contacts(np.array(some)).min(axis=0)
    many = sweeps.contacts(np.array(some + more)).min(axis=0)
    assert (many <= few).all()


@given(
    place=places,
    direction=st.sampled_from([F, B, L, R]),
    more=st.floats(0.0, 0.1),
)
@settings(max_examples=80, deadline=None)
def test_larger_margins_never_leave_more_room(
    place: tuple[float, float], direction: int, more: float
) -> None:
    x, y = place
    wide = Footprint(CHAIR.body, Margins(0.05 + more, 0.02 + more, 0.05 + more))
    assume(not wide.contains(np.array([[x, y]]))[0])
    assert contact(wide, x, y, direction) <= contact(CHAIR, x, y, direction) + 1e-6


def test_forward_and_backward_in_figures() -> None:
    assert contact(CHAIR, 1.70, 0.0, F) == pytest.approx(1.0)
    assert contact(CHAIR, 1.70, 0.0, B) == math.inf
    assert contact(CHAIR, -1.50, 0.1, B) == pytest.approx(1.0)
    assert contact(CHAIR, 1.70, 0.50, F) == math.inf  # 9 cm beside the margin
    # 1 m on a path that points 1 degree off leads 1.7 cm aside.
    assert contact(CHAIR, 1.70, 0.41, F) == pytest.approx(1.0, abs=0.01)
    assert contact(CHAIR, 1.70, 0.45, F) == math.inf
    assert contact(CHAIR, 9.0, 0.0, F) == math.inf


def test_the_rotating_corners_literally() -> None:
    bare = Footprint(margins=BARE)
    wall_m = 0.525  # a wall 15 cm beside the chair, to its left
    front, rear = math.hypot(0.65, 0.375), math.hypot(0.45, 0.375)
    wall = np.column_stack((np.linspace(-3, 3, 6001), np.full(6001, wall_m)))
    ways = Sweeps(bare).contacts(wall).min(axis=0)
    # Left: the front corner, from 30 degrees up to where it reaches the wall.
    own = math.degrees(math.atan2(0.375, 0.65))
    assert ways[L] == pytest.approx(math.degrees(math.asin(wall_m / front)) - own, abs=0.1)
    # Right: the rear corner swings out to the left.
    own = 180.0 - math.degrees(math.atan2(0.375, 0.45))
    assert ways[R] == pytest.approx(own - (180 - math.degrees(math.asin(wall_m / rear))), abs=0.1)
    assert ways[F] == ways[B] == math.inf
    # Beyond the longest corner it turns freely.
    assert np.isinf(contact(bare, 0.0, front + 0.001, L))
    assert contact(bare, 0.0, front - 0.001, L) < 90.0
    # A cupboard beside the rear wheels: front is free, the turn away from it is not.
    assert contact(bare, -0.3, 0.5, F) == math.inf
    assert contact(bare, -0.3, 0.5, R) < 20.0 < contact(bare, -0.3, 0.5, L)


def test_what_is_in_the_margin_ahead_leaves_the_way_back() -> None:
    close = (0.67, 0.1)  # 2 cm before the front
    assert contact(CHAIR, *close, F) == pytest.approx(0.02)
    assert contact(CHAIR, *close, B) == math.inf
    # Circling, the front edge comes to it after 25 degrees one way, 8 the other.
    assert contact(CHAIR, *close, L) > contact(CHAIR, *close, R) > 5.0


def test_a_wall_within_the_side_margin_does_not_hold_the_chair() -> None:
    beside = np.column_stack((np.linspace(-0.44, 0.64, 200), np.full(200, 0.39)))
    ways = Sweeps(CHAIR).contacts(beside).min(axis=0)
    assert ways[F] == ways[B] == math.inf
    assert ways[L] < 5.0
    assert ways[R] < 5.0


def test_a_hand_within_the_outline_stops_what_presses_it() -> None:
    hand = (0.62, 0.1)
    assert contact(CHAIR, *hand, F) == 0.0
    assert contact(CHAIR, *hand, B) == math.inf
    assert contact(CHAIR, 0.1, 0.36, F) == math.inf  # along the side: neither deeper nor shallower


@given(
    gap=st.floats(0.0005, 0.0495),
    y=st.floats(-0.37, 0.37),
    direction=st.sampled_from([F, B]),
)
def test_away_from_what_touches_the_margin_is_always_free(
    gap: float, y: float, direction: int
) -> None:
    x = 0.65 + gap if direction == F else -0.45 - gap
    assert contact(CHAIR, x, y, direction) == pytest.approx(gap)
    assert contact(CHAIR, x, y, B if direction == F else F) == math.inf


@given(place=places, direction=st.sampled_from([F, B, L, R]))
@settings(max_examples=80, deadline=None)
def test_within_the_margin_the_body_never_touches_before_the_way_ends(
    place: tuple[float, float], direction: int
) -> None:
    beside = max(abs(place[0]), abs(place[1]), 0.1) / 2.0  # pushed out to the margin
    x, y = 0.1 + 0.575 * place[0] / 2.0 / beside, 0.39 * place[1] / 2.0 / beside
    point = np.array([[x, y]])
    assume(CHAIR.contains(point)[0] and not inside(CHAIR.body, point)[0])
    way = contact(CHAIR, x, y, direction)
    end = min(way, RANGE_M if direction in (F, B) else 360.0)
    path = moved(x, y, direction, np.linspace(0.0, max(0.0, end - 1e-6), 2000), 0.0)
    assert not inside(CHAIR.body, path).any()
