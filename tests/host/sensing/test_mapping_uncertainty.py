"""A pose's claimed accuracy covers the disagreement of the map's surfaces."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.sensing.mapping.locating.uncertainty import Unsteady, disagreement, sigmas_of
from gazechair.sensing.mapping.matching import ndt

ORIGIN = np.zeros(2)


def room(left_m: float = 0.0) -> np.ndarray:
    """Walls of 4 m x 3 m around the origin, a pillar; the left one is that much farther out."""
    along, across = np.arange(-2.0, 2.0, 0.02), np.arange(-1.5, 1.5, 0.02)
    parts = [np.stack((along, np.full_like(along, y)), axis=1) for y in (-1.5, 1.5)]
    parts += [np.stack((np.full_like(across, x), across), axis=1) for x in (-2.0 - left_m, 2.0)]
    pillar = np.stack((np.full(20, 1.0), np.arange(-0.2, 0.2, 0.02)), axis=1)
    return np.concatenate((*parts, pillar))


def off_and_sigma_m(left_m: float) -> tuple[float, float]:
    """The uncertainty at a pose in the room, by a map with the left wall elsewhere."""
    chance = np.random.default_rng(2)
    grid, seen = ndt.NdtGrid(room(left_m)), room() + chance.normal(0.0, 0.006, room().shape)
    fitted = ndt.fit(grid, seen, np.zeros(3))
    disagrees = disagreement(grid, seen, fitted.pose, ORIGIN)
    return math.hypot(*fitted.pose[:2]), sigmas_of(fitted.information, 0.025, disagrees)[0]


@pytest.mark.parametrize("left_m", [-0.06, 0.05, 0.08])
def test_a_wall_that_is_drawn_elsewhere_makes_the_place_less_sure(left_m: float) -> None:
    off_m, sigma_m = off_and_sigma_m(left_m)
    assert off_m < 2.0 * sigma_m
    assert sigma_m > 1.2 * off_and_sigma_m(0.0)[1]


def test_a_right_map_is_as_sure_as_ever() -> None:
    off_m, sigma_m = off_and_sigma_m(0.0)
    assert off_m < 0.003
    assert sigma_m == pytest.approx(0.018, abs=0.001)


def test_large_cells_are_right_within_what_they_round() -> None:
    fitted = ndt.fit(ndt.NdtGrid(room()), room(), np.zeros(3))
    own, drawn, coarse = (
        sigmas_of(fitted.information, cell_m)[0] for cell_m in (0.025, 0.04, 0.10)
    )
    assert own == pytest.approx(0.018, abs=0.001)
    assert own < drawn < coarse
    assert coarse == pytest.approx(math.hypot(0.018, 0.10 / math.sqrt(12.0)), abs=0.001)


def test_places_that_move_against_odometry_are_unsteady_until_they_are_left_behind() -> None:
    unsteady, place = Unsteady(), np.zeros(3)
    for step in range(8):  # odometry is 2 % off
        assert unsteady.judge(np.array((0.1 * step, 0.0, 0.0)), place) == 0.0
        place = np.array((0.102 * (step + 1), 0.0, 0.0))
    shifted = np.array((0.1 * 8, 0.09, 0.0))
    assert 0.05 < unsteady.judge(shifted, place) < 0.1
    for step in range(70):
        moved = np.array((0.1 * step, 0.0, 0.0))
        last = unsteady.judge(shifted + moved, place + moved)
    assert last == 0.0


def test_who_was_carried_elsewhere_begins_anew() -> None:
    unsteady, standing = Unsteady(), np.zeros(3)
    for _ in range(3):
        assert unsteady.judge(standing, standing) == 0.0
    assert unsteady.judge(np.array((3.0, 1.0, 2.0)), standing) == 0.0
