"""Who is followed: choosing, losing, finding again, and never taking another person."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from followrig import SCAN_S, Disc, Place, Scene, legs
from gazechair.following.legs import Cluster
from gazechair.following.person import Person, State
from gazechair.following.request import STOP
from gazechair.following.tracks import Track


def test_chosen_by_standing_in_front() -> None:
    scene = Scene()
    followed = scene.comes()
    assert followed.state is State.FOLLOWS
    assert followed.person_m == pytest.approx((1.85, 0.0), abs=0.08)


def test_not_chosen_before_two_seconds() -> None:
    scene = Scene()
    for k in range(30):
        scene.look(legs((3.35 - 0.05 * k, 0.0), 0.05 * k))
    scene.follower.choose(scene.at_s)
    states = [scene.look(legs((1.85, 0.0))).state for _ in range(18)]
    assert set(states) == {State.CHOOSING}


def test_two_in_front_are_not_chosen_from() -> None:
    scene = Scene()
    for k in range(30):
        far = 3.35 - 0.05 * k
        scene.look([*legs((far, -0.3), 0.05 * k), *legs((far, 0.3), 0.05 * k)])
    scene.follower.choose(scene.at_s)
    for _ in range(24):
        followed = scene.look([*legs((1.85, -0.3)), *legs((1.85, 0.3))])
    assert followed.state is State.UNSURE
    assert followed.request == STOP


def test_chosen_by_a_look() -> None:
    scene = Scene()
    for k in range(30):
        far = 3.35 - 0.05 * k
        scene.look([*legs((far, -0.8), 0.05 * k), *legs((far, 0.8), 0.05 * k)])
    scene.follower.choose(scene.at_s, 0.38)
    for _ in range(8):
        followed = scene.look([*legs((1.85, -0.8)), *legs((1.85, 0.8))])
    assert followed.state is State.FOLLOWS
    assert followed.person_m == pytest.approx((1.85, 0.8), abs=0.1)


def test_a_look_between_two_is_unsure() -> None:
    scene = Scene()
    for k in range(30):
        far = 3.35 - 0.05 * k
        scene.look([*legs((far, -0.3), 0.05 * k), *legs((far, 0.3), 0.05 * k)])
    scene.follower.choose(scene.at_s, 0.05)
    assert scene.look([*legs((1.85, -0.3)), *legs((1.85, 0.3))]).state is State.UNSURE


def test_who_walks_through_a_look_is_not_taken_for_who_is_meant() -> None:
    scene = Scene()
    for k in range(30):
        scene.look(legs((1.85, 2.0 - 0.05 * k), 0.05 * k, 1.57))
    scene.follower.choose(scene.at_s, 0.0)  # at nobody whom the lidar sees
    states = {scene.look(legs((1.85, 0.5 - 0.1 * k), 0.1 * k, 1.57)).state for k in range(20)}
    assert states == {State.CHOOSING, State.NOBODY}


def test_what_never_walked_is_not_chosen_without_a_map() -> None:
    scene = Scene()
    scene.follower.choose(0.0)
    states = {scene.look(legs((1.85, 0.0))).state for _ in range(40)}
    assert State.FOLLOWS not in states


def test_who_was_lost_and_stands_still_is_in_the_way_of_another_choice() -> None:
    scene = Scene()
    scene.comes()
    for _ in range(15):
        lost = scene.look([])
    for k in range(40):  # stands there again; somebody comes and stands beside
        other = legs((1.75, max(0.55, 2.5 - 0.08 * k)), 0.08 * min(k, 25), -1.57)
        scene.look([*legs((1.85, 0.0)), *other])
    scene.follower.choose(scene.at_s)
    states = {scene.look([*legs((1.85, 0.0)), *other]).state for _ in range(30)}
    assert lost.state is State.LOST
    assert states == {State.CHOOSING, State.UNSURE}


def test_who_was_lost_needs_fewer_steps_to_be_chosen_again() -> None:
    scene = Scene()
    scene.comes()
    for _ in range(15):
        lost = scene.look([])
    for k in range(13):
        scene.look(legs((2.45 - 0.05 * k, 0.0), 0.05 * k, math.pi))
    scene.follower.choose(scene.at_s)
    for _ in range(30):
        followed = scene.look(legs((1.85, 0.0)))
    assert lost.state is State.LOST
    assert followed.state is State.FOLLOWS


def test_out_of_sight_asks_for_nothing_at_once_and_is_said() -> None:
    scene = Scene()
    scene.comes()
    for k in range(15):
        followed = scene.look(legs((1.85 + 0.06 * k, 0.0), 0.06 * k))
    assert followed.request.linear_m_s > 0.2
    away = [scene.look([]) for _ in range(15)]
    assert all(one.request == STOP for one in away)
    assert away[-1].state is State.LOST
    # Whoever comes now has to be chosen.
    assert all(scene.look(legs((2.5, 0.0))).state is State.LOST for _ in range(20))


def test_a_scan_without_the_person_costs_a_little_speed_only() -> None:
    scene = Scene()
    scene.comes()
    for k in range(20):
        before = scene.look(legs((1.85 + 0.06 * k, 0.0), 0.06 * k)).request.linear_m_s
    assert scene.look([]).request == STOP
    after = scene.look(legs((1.85 + 0.06 * 21, 0.0), 0.06 * 21)).request.linear_m_s
    assert before - 0.06 < after <= before + 0.03


def test_a_person_whose_track_ended_as_a_double_is_out_of_sight() -> None:
    person = Person(0.65, needs_steps=False)
    legs_of_it = [
        Cluster(1.85, side * 0.09, False, True, True, np.zeros((0, 2))) for side in (1.0, -1.0)
    ]
    track = Track(1, 1.85, 0.0, 0.0, looks=9, shapes=9, legs=legs_of_it)
    person.choose(0.0, 0.0)
    states = {}
    for k in range(40):
        at_s = k * SCAN_S
        tracks = [track] if at_s < 1.0 else []  # a double ends with its legs, and is not told of
        track.seen_s = min(at_s, 0.9)
        person.look(tracks, [], np.zeros(3), at_s)
        states[k] = person.state
    assert states[9] is State.FOLLOWS
    assert State.FOLLOWS not in [states[k] for k in range(14, 40)]
    assert states[39] is State.LOST


def _walks_behind_something(scene: Scene, hidden: int) -> float:
    """The person walks to the left, then is not seen for so many scans; returns where they were."""
    left = 0.0
    for k in range(8):
        scene.look(legs((1.85 + 0.05 * k, 0.0), 0.05 * k))
    for k in range(20):
        left = 0.05 * k
        scene.look(legs((2.2, left), left, 1.57))
    for _ in range(hidden):
        scene.look([])
    return left + 0.05 * hidden


def test_found_again_where_and_as_expected() -> None:
    scene = Scene()
    scene.comes()
    left = _walks_behind_something(scene, 5)
    assert scene.follower.state is State.HIDDEN
    for k in range(1, 10):
        followed = scene.look(legs((2.2, left + 0.05 * k), left + 0.05 * k, 1.57))
    assert followed.state is State.FOLLOWS


@pytest.mark.parametrize(("x_m", "step_m"), [(2.2, -0.06), (2.75, 0.05), (1.7, 0.05)])
def test_another_who_appears_instead_is_not_followed(x_m: float, step_m: float) -> None:
    scene = Scene()
    scene.comes()
    left = _walks_behind_something(scene, 5)
    for k in range(1, 25):
        there = left + step_m * k
        assert scene.look(legs((x_m, there), there, 1.57)).state is not State.FOLLOWS


def test_two_who_touch_are_unsure() -> None:
    scene = Scene()
    scene.comes()
    states = []
    for k in range(30):
        far = max(0.30, 2.0 - 0.08 * k)
        discs: list[Disc] = [*legs((1.85, 0.0)), *legs((1.85, far), 0.08 * k, 1.57)]
        states.append(scene.look(discs).state)
    assert states[8] is State.FOLLOWS
    assert states[-1] is State.UNSURE


def test_one_who_crosses_behind_changes_nothing() -> None:
    scene = Scene()
    scene.comes()
    for k in range(40):
        other = legs((2.9, 2.0 - 0.1 * k), 0.1 * k, 1.57)
        followed = scene.look([*legs((1.85, 0.0)), *other])
        assert followed.state is State.FOLLOWS
        assert followed.person_m == pytest.approx((1.85, 0.0), abs=0.15)


def test_one_who_crosses_between_is_never_followed() -> None:
    scene = Scene()
    scene.comes()
    for k in range(40):
        followed = scene.look([*legs((1.85, 0.0)), *legs((1.2, 2.0 - 0.1 * k), 0.1 * k, 1.57)])
        if followed.person_m is not None:
            assert followed.person_m == pytest.approx((1.85, 0.0), abs=0.2)


@pytest.mark.parametrize(("pillar_m", "x_m", "beyond_m"), [(2.7, 3.35, 0.45), (2.9, 3.35, 0.45)])
def test_another_who_comes_out_where_the_person_hides_is_not_followed(
    pillar_m: float, x_m: float, beyond_m: float
) -> None:
    scene = Scene()
    pillar: list[Disc] = [(pillar_m, -0.45, 0.25)]
    assert scene.comes(pillar).state is State.FOLLOWS
    walk = [(1.85 + (x_m - 1.85) * k / 20.0, 0.5 * k / 20.0) for k in range(21)]
    walk += [(x_m, 0.5 - 0.06 * k) for k in range(1, 17)]  # behind the pillar, and stays there
    for k in range(len(walk) + 30):
        person = walk[min(k, len(walk) - 1)]
        up = min(max((k - len(walk) + 5) / 7.0, 0.0), 1.0)
        other = (x_m + beyond_m - 0.1 * up, -0.5 + 0.45 * up)  # from behind it, beside its edge
        followed = scene.look(
            [*legs(person, 0.06 * k, -1.57), *legs(other, 0.3 * up, 1.57), *pillar]
        )
        if k >= len(walk) + 5:
            assert followed.request == STOP
            assert followed.person_m is None or math.dist(followed.person_m, person) < 0.35


_PILLAR: list[Disc] = [(2.0, -0.35, 0.2)]
"""At x = 3.0 m it hides what is to the right of y = -0.25 m."""


def test_a_part_of_a_leg_that_stays_where_it_was_is_still_theirs() -> None:
    scene = Scene()
    scene.comes(_PILLAR)
    for k in range(24):
        scene.look([*legs((1.85 + 0.05 * k, 0.0), 0.05 * k), *_PILLAR])
    for k in range(12):  # one leg goes out of sight, of the other one a half
        scene.look([*legs((3.0, -0.0275 * k)), *_PILLAR])
    for _ in range(30):
        followed = scene.look([*legs((3.0, -0.33)), *_PILLAR])
        assert followed.state is State.FOLLOWS
        assert followed.request.linear_m_s > 0.0


def test_a_part_of_a_skirt_is_still_theirs() -> None:
    scene = Scene()
    for k in range(30):
        scene.look([(3.35 - 0.05 * k, 0.0, 0.18), *_PILLAR])
    scene.follower.choose(scene.at_s)
    for _ in range(24):
        scene.look([(1.85, 0.0, 0.18), *_PILLAR])
    for k in range(24):
        scene.look([(1.85 + 0.05 * k, 0.0, 0.18), *_PILLAR])
    for k in range(40):
        followed = scene.look([(3.0, -0.03 * min(k, 6), 0.18), *_PILLAR])
        assert followed.state is State.FOLLOWS
        assert followed.request.linear_m_s > 0.0


def test_a_leg_that_was_not_there_a_scan_before_is_not_theirs() -> None:
    scene = Scene()
    scene.comes()
    for k in range(15):
        here = (1.85 + 0.06 * k, 0.0)
        assert scene.look(legs(here, 0.06 * k)).person_m is not None
    followed = scene.look([(here[0] + 0.25, 0.25, 0.055)])
    assert followed.person_m is None
    assert followed.request == STOP


def _along(points: list[Place], speed_m_s: float) -> list[tuple[Place, float]]:
    """Where somebody is in each scan who walks along these points, and their heading."""
    found = []
    for a, b in pairwise(points):
        steps = max(1, round(math.dist(a, b) / (speed_m_s * SCAN_S)))
        for k in range(1, steps + 1):
            place = a[0] + (b[0] - a[0]) * k / steps, a[1] + (b[1] - a[1]) * k / steps
            found.append((place, math.atan2(b[1] - a[1], b[0] - a[0])))
    return found


@pytest.mark.parametrize(
    ("x_m", "apart_m", "late", "speed_m_s"),
    [(3.05, 0.42, 0, 0.5), (3.05, 0.46, 2, 0.7), (3.2, 0.46, 2, 0.7), (3.4, 0.42, 2, 0.7)],
)
def test_another_who_comes_out_as_the_person_goes_in_is_not_followed(
    x_m: float, apart_m: float, late: int, speed_m_s: float
) -> None:
    scene = Scene()
    wall: list[Disc] = [(2.75, -0.5 - 0.15 * k, 0.12) for k in range(8)]
    scene.comes(wall)
    far_m = x_m + apart_m
    person = _along([(1.85, 0.0), (far_m, 0.45), (far_m, -0.9)], speed_m_s)
    other = _along([(x_m, -0.9), (x_m, 0.0), (x_m - 0.2, 0.5)], speed_m_s)
    goes_in = next(k for k, (at, _) in enumerate(person) if at[0] == far_m and at[1] < -0.25)
    comes_out = next(k for k, (at, _) in enumerate(other) if at[1] > -0.3)
    step_m = speed_m_s * SCAN_S
    for k in range(len(person) + 25):
        (here, heading), mine = person[min(k, len(person) - 1)], min(k, len(person) - 1)
        theirs = min(max(k - goes_in + comes_out - late, 0), len(other) - 1)
        there, other_heading = other[theirs]
        followed = scene.look(
            [
                *legs(here, step_m * mine, heading),
                *legs(there, step_m * theirs, other_heading),
                *wall,
            ]
        )
        if followed.person_m is not None:
            assert math.dist(followed.person_m, here) < 0.5
        if k > goes_in + 10:
            assert followed.request == STOP


@pytest.mark.parametrize("behind_m", [0.0, 0.05, 0.1])
def test_a_skirt_that_comes_out_beside_a_skirt_is_not_followed_along(behind_m: float) -> None:
    """A pillar hides somebody close beside the person; both walk out from it, and then part."""
    scene = Scene()
    pillar: list[Disc] = [(1.2, 0.33, 0.2)]
    other = (1.85 + behind_m, 0.47)
    for k in range(30):
        scene.look([(3.35 - 0.05 * k, 0.0, 0.2), (*other, 0.2), *pillar])
    scene.follower.choose(scene.at_s)
    for _ in range(24):
        followed = scene.look([(1.85, 0.0, 0.2), (*other, 0.2), *pillar])
    assert followed.state is State.FOLLOWS
    for k in range(40):
        side = -0.03 * min(k, 20)
        away = 0.05 * max(0, k - 20)
        people = [(1.85, side, 0.2), (other[0] - 0.5 * away, other[1] + side + away, 0.2)]
        followed = scene.look([*people, *pillar])
        if followed.person_m is not None:
            assert math.dist(followed.person_m, (1.85, side)) < 0.15
