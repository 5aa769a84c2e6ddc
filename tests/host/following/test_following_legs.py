"""Legs, background and tracks in single scans."""

from __future__ import annotations

import math

import numpy as np
import pytest

from followrig import Scene, legs
from gazechair.following.background import Background
from gazechair.following.legs import Cluster, clusters, continued
from gazechair.following.tracks import Tracks
from gazesim.gaits import FOREIGN, PLAIN, Actor

_ORIGIN = np.array((0.5, 0.0))


def _seen(discs: list[tuple[float, float, float]]) -> list[Cluster]:
    points = Scene().scan(discs).points_m
    near = np.hypot(points[:, 0], points[:, 1]) < 4.0
    return clusters(points, _ORIGIN, near)


def test_two_legs_are_two_clusters() -> None:
    found = _seen(legs((2.5, 0.0)))
    assert sorted((round(one.x_m, 1), round(one.y_m, 1), one.wide) for one in found) == [
        (2.5, -0.1, False),
        (2.5, 0.1, False),
    ]


def test_a_skirt_is_one_wide_cluster() -> None:
    (one,) = _seen([(2.5, 0.3, 0.18)])
    assert one.wide
    assert (one.x_m, one.y_m) == pytest.approx((2.5, 0.3), abs=0.06)


def test_a_pole_is_nobody() -> None:
    assert _seen([(1.8, 0.2, 0.015)]) == []


def test_a_part_of_something_wide_is_nobody() -> None:
    # Two legs before a wall of which a strip shows between them.
    found = _seen([(1.5, 0.28, 0.06), (1.5, -0.28, 0.06), (3.2, 0.0, 1.0)])
    assert not any(one.wide and not one.maybe_wall for one in found)


def test_what_stands_becomes_background_and_what_leaves_does_not_stay() -> None:
    scene, background = Scene(), Background()
    post = [(2.5, 0.0, 0.06)]
    for _ in range(20):
        points = scene.scan(post).points_m
        stands = background.stands(points, _ORIGIN)
        background.learn(points, _ORIGIN, [])
    near = np.hypot(points[:, 0] - 2.5, points[:, 1]) < 0.2
    assert stands[near].all()
    for _ in range(40):
        points = scene.scan([]).points_m
        background.stands(points, _ORIGIN)
        background.learn(points, _ORIGIN, [])
    points = scene.scan(post).points_m
    near = np.hypot(points[:, 0] - 2.5, points[:, 1]) < 0.2
    assert not background.stands(points, _ORIGIN)[near].any()


def test_nothing_is_learned_next_to_a_person() -> None:
    scene, background = Scene(), Background()
    for _ in range(40):
        points = scene.scan(legs((2.5, 0.0))).points_m
        stands = background.stands(points, _ORIGIN)
        background.learn(points, _ORIGIN, [(2.5, 0.0)])
    near = np.hypot(points[:, 0] - 2.5, points[:, 1]) < 0.3
    assert not stands[near].any()


@pytest.mark.parametrize("gait", [PLAIN, *sorted(set(FOREIGN))])
def test_a_walker_is_one_track(gait: str) -> None:
    import random

    actor = Actor(2.2, -1.0, gait, random.Random(3))
    tracks, scene = Tracks(), Scene()
    for k in range(50):
        actor.go(2.2, -1.0 + 0.04 * k)
        points = scene.scan(actor.legs()).points_m
        near = np.hypot(points[:, 0], points[:, 1]) < 4.0
        tracks.look(clusters(points, _ORIGIN, near), 0.1 * k)
        people = [one for one in tracks.all if one.walked]
    (one,) = people
    assert math.dist((one.x_m, one.y_m), (actor.x_m, actor.y_m)) < 0.25
    assert one.vy_m_s == pytest.approx(0.4, abs=0.25)


def _part(x_m: float, y_m: float, width_m: float = 0.1, free: bool = True) -> Cluster:
    y = np.linspace(y_m - 0.5 * width_m, y_m + 0.5 * width_m, 8)
    return Cluster(x_m, y_m, width_m > 0.23, True, free, np.stack((np.full(8, x_m), y), axis=1))


def test_what_lies_where_they_were_is_theirs_also_merged_split_or_hidden_in_part() -> None:
    left, right = _part(2.0, 0.1), _part(2.0, -0.1)
    merged = _part(2.0, 0.0, 0.3)
    for before, now in (
        ([left, right], [_part(2.1, 0.1), _part(2.0, -0.1)]),
        ([left, right], [merged]),
        ([merged], [left, right]),
        ([left, right], [_part(2.0, 0.12, 0.03)]),
    ):
        assert set(continued(before, before, now)) == set(now)


@pytest.mark.parametrize("now", [_part(2.3, 0.0), _part(2.0, 0.3), _part(2.0, 0.15, 0.3)])
def test_what_reaches_far_beyond_where_they_were_is_not_theirs(now: Cluster) -> None:
    own = _part(2.0, 0.0)
    assert continued([own], [own], [now]) == []


def test_a_part_of_a_wall_that_appears_behind_a_leg_is_not_theirs() -> None:
    own = _part(2.0, 0.0)
    leg, wall = _part(2.0, 0.06), _part(2.15, 0.0, free=False)
    assert continued([own], [own], [wall, leg]) == [leg]


def test_what_fits_somebody_elses_leg_better_is_not_theirs() -> None:
    own, other = _part(2.0, 0.0), _part(2.15, 0.0)
    assert continued([own], [own, other], [_part(2.12, 0.0)]) == []


@pytest.mark.parametrize(
    ("own", "other"),
    [
        (_part(2.0, 0.0, 0.4), _part(2.1, 0.3)),
        (_part(2.0, 0.0, 0.4), _part(2.1, 0.2, 0.3)),
        (_part(2.0, 0.0), _part(2.15, 0.1)),
        (_part(2.0, 0.0), _part(2.15, 0.0, 0.3)),
    ],
)
def test_what_comes_out_from_behind_them_is_not_theirs(own: Cluster, other: Cluster) -> None:
    assert continued([own], [own], [other, own]) == [own]


def test_legs_too_far_apart_for_one_person_are_not_certainly_theirs() -> None:
    legs_before = [_part(2.0, 0.27), _part(2.0, -0.27)]
    legs_now = [_part(2.0, 0.29), _part(2.0, -0.29)]
    assert continued(legs_before, legs_before, legs_before) != []
    assert continued(legs_before, legs_before, legs_now) == []
