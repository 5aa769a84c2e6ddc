"""A lidar turned too far for a fit is detected at once, because its view is rotated."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.sensing.odometry.local_map import LocalMap, layers_of
from gazechair.sensing.odometry.turned_piece import TurnedPiece

LIDAR = (0.5, 0.0)
HERE = (0.3, -0.2, 0.4)


def seen(chair: tuple[float, float, float], turned_deg: float = 0.0) -> tuple[np.ndarray, ...]:
    """Points and normals, in the chair's frame, of a room of 5 m x 3.6 m with a cupboard."""
    beams = np.radians(np.arange(-120.0, 120.0, 1.0))
    c, s = math.cos(chair[2]), math.sin(chair[2])
    origin = np.array((chair[0] + c * LIDAR[0], chair[1] + s * LIDAR[0]))
    real = beams + chair[2] + math.radians(turned_deg)  # where it looks; it is taken for `beams`
    along = np.stack((np.cos(real), np.sin(real)), axis=1)
    high, low = np.array((2.6, 1.7)), np.array((-2.4, -1.9))
    both = np.where(along > 0, high - origin, low - origin) / along
    metres = both.min(axis=1)
    normals = np.where((both == metres[:, None]), -np.sign(along), 0.0)
    wide = np.abs(origin[1] + metres * along[:, 1]) < 0.5
    near = wide & (along[:, 0] > 0.0)
    metres = np.where(near, (2.1 - origin[0]) / along[:, 0], metres)
    points = np.array(LIDAR) + metres[:, None] * np.stack((np.cos(beams), np.sin(beams)), axis=1)
    back = math.radians(turned_deg) + chair[2]
    turn = np.array(((math.cos(back), -math.sin(back)), (math.sin(back), math.cos(back))))
    return points, normals @ turn


@pytest.fixture(scope="module")
def surfaces() -> LocalMap:
    known = LocalMap(0.10)
    points, normals = seen(HERE)
    c, s = math.cos(HERE[2]), math.sin(HERE[2])
    turn = np.array(((c, s), (-s, c)))
    chance = np.random.default_rng(4)
    for at_s in range(4):
        noisy = points @ turn + HERE[:2] + chance.normal(0.0, 0.006, points.shape)
        known.insert(noisy, layers_of(normals @ turn), float(at_s))
    return known


@pytest.mark.parametrize("turned_deg", [-14.0, -9.0, 6.0, 9.0, 12.0])
def test_what_would_lie_on_the_walls_were_it_turned_is_noticed_with_the_second_piece(
    surfaces: LocalMap, turned_deg: float
) -> None:
    piece, (points, normals) = TurnedPiece(), seen(HERE, turned_deg)
    assert not piece.judge(surfaces, points, normals, LIDAR, HERE, 0.4)
    assert piece.judge(surfaces, points, normals, LIDAR, HERE, 0.4)


def test_a_piece_that_lies_where_it_should_and_another_room_are_no_turn(
    surfaces: LocalMap,
) -> None:
    piece, (points, normals) = TurnedPiece(), seen(HERE)
    other = seen((1.9, 1.1, 2.0))
    for _ in range(4):
        assert not piece.judge(surfaces, points, normals, LIDAR, HERE, 0.95)
        assert not piece.judge(surfaces, *other, LIDAR, HERE, 0.3)
    empty = np.zeros((0, 2))
    assert not piece.judge(surfaces, empty, empty, LIDAR, HERE, 0.0)


def test_the_half_of_a_turn_that_fits_by_chance_does_not_hide_that_the_other_is_turned(
    surfaces: LocalMap,
) -> None:
    piece, (points, normals) = TurnedPiece(), seen(HERE, 9.0)
    assert not piece.judge(surfaces, points, normals, LIDAR, HERE, 0.4)
    assert not piece.judge(surfaces, points, normals, LIDAR, HERE, 0.95)
    assert piece.judge(surfaces, points, normals, LIDAR, HERE, 0.4)
