"""Objects seen in several looks are kept; people who walk and objects of one look are not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.sensing.mapping.locating.recent_looks import RecentLooks, Settled

ANGLES = np.radians(np.arange(-80.0, 80.0, 0.5))
WALL_M = 3.0  # ahead, across
HERE = np.zeros(2)


def beams(
    person_m: tuple[float, float] | None = None, at_m: np.ndarray = HERE
) -> tuple[np.ndarray, np.ndarray]:
    """A look of a lidar `at_m` before the wall; a person hides what is behind them."""
    away = (WALL_M - at_m[0]) / np.cos(ANGLES)
    if person_m is not None:
        to = np.array(person_m) - at_m
        off = np.abs(ANGLES - math.atan2(to[1], to[0]))
        away = np.where(off < 0.15 / np.hypot(*to), np.minimum(away, np.hypot(*to)), away)
    ends = at_m + away[:, None] * np.stack((np.cos(ANGLES), np.sin(ANGLES)), axis=1)
    return np.tile(at_m, (len(ends), 1)), ends


def settled(people: list[tuple[float, float] | None]) -> Settled:
    looks = RecentLooks()
    for person in people:
        looks.add(*beams(person), HERE)
    found = looks.settled()
    assert found is not None
    return found


def off_the_wall(found: Settled) -> np.ndarray:
    return found.surfaces_m[np.abs(found.surfaces_m[:, 0] - WALL_M) > 0.06]


def test_who_walks_leaves_nothing_and_the_wall_behind_them_stays() -> None:
    found = settled([(1.2, 0.3 * k - 0.9) for k in range(7)])
    assert len(off_the_wall(found)) == 0
    behind = found.surfaces_m[:, 1]
    assert np.diff(np.sort(behind[np.abs(behind) < 2.0])).max() < 0.11
    assert found.is_free(np.array([(1.2, 0.0), (2.0, 0.3)])).all()


def test_who_stands_stays_and_nothing_is_free_around_them() -> None:
    found = settled([(1.2, 0.3)] * 5)
    assert len(off_the_wall(found)) > 2
    assert not found.is_free(np.array([(1.2, 0.3), (1.15, 0.3), (2.5, 0.62)])).any()
    assert found.is_free(np.array([(1.2, -0.3)])).all()


def test_one_look_tells_nothing() -> None:
    looks = RecentLooks()
    assert looks.settled() is None
    looks.add(*beams(), HERE)
    assert looks.settled() is None


def test_nothing_at_a_wall_is_free_however_slantwise_it_is_seen() -> None:
    found = settled([None] * 6)
    along = np.arange(-9.0, 9.0, 0.02)
    for before_m in (-0.05, 0.0, 0.05, 0.5):  # behind it, too
        places = np.stack((np.full(len(along), WALL_M + before_m), along), axis=1)
        assert not found.is_free(places).any()
    ahead = np.stack((np.full(len(along), WALL_M - 0.6), along), axis=1)
    assert found.is_free(ahead[np.abs(along) < 1.0]).mean() > 0.8


def test_the_floor_that_the_chair_stood_on_is_free() -> None:
    found = settled([None] * 3)
    assert found.is_free(np.array([(0.0, 0.0), (-0.15, 0.1)])).all()
    assert not found.is_free(np.array([(-0.5, 0.0), (99.0, 0.0)])).any()


def test_it_forgets_what_it_saw_long_ago() -> None:
    looks = RecentLooks()
    for _ in range(15):
        looks.add(*beams((1.2, 0.3)), HERE)
    for _ in range(15):
        looks.add(*beams(), HERE)
    found = looks.settled()
    assert found is not None
    assert len(off_the_wall(found)) == 0
    looks.forget()
    assert looks.settled() is None


@pytest.mark.parametrize("far_m", [(400.0, -300.0), (-700.0, 650.0)])
def test_it_is_the_same_far_from_where_odometry_began(far_m: tuple[float, float]) -> None:
    near = settled([None] * 3)
    looks, off = RecentLooks(), np.array(far_m)
    for _ in range(3):
        starts, ends = beams()
        looks.add(starts + off, ends + off, HERE + off)
    far = looks.settled()
    assert far is not None
    moved = np.sort(far.surfaces_m - off, axis=0)
    assert moved == pytest.approx(np.sort(near.surfaces_m, axis=0), abs=0.051)
    assert far.is_free(np.array([(1.0, 0.0)]) + off).all()


def test_a_mirror_image_has_the_surfaces_and_the_floor_on_the_other_side() -> None:
    found = settled([(1.2, 0.3)] * 5)
    image = found.mirrored()
    assert np.allclose(image.surfaces_m, found.surfaces_m * (1.0, -1.0))
    at = np.stack(np.meshgrid(np.arange(0.0, 3.5, 0.05), np.arange(-4.0, 4.0, 0.05)), axis=-1)
    at = at.reshape(-1, 2) + 0.025
    assert (image.is_free(at * (1.0, -1.0)) == found.is_free(at)).all()
    assert (image.is_free(at) != found.is_free(at)).any()
