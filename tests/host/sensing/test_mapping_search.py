"""Scans are found in the map: exactly, everywhere in the window, and not at two places."""

from __future__ import annotations

import itertools
import math
import tracemalloc

import numpy as np
import pytest

from gazechair.base.angles import half_turn_rad
from gazechair.base.poses import between, compose, from_frame, to_frame
from gazechair.sensing.mapping.matching import ndt
from gazechair.sensing.mapping.matching.correlative_search import search
from gazechair.sensing.mapping.matching.likelihood_field import LikelihoodField
from homerig import flat, points, scan

CHANCE = np.random.default_rng(3)
POSE = np.array((2.0, 1.8, 0.7))
ROOM_M = to_frame(points(*scan(flat(), POSE, CHANCE)), POSE)


def seen_from(pose: np.ndarray) -> np.ndarray:
    return points(*scan(flat(), pose, np.random.default_rng(4)))


def test_poses_compose_and_invert() -> None:
    a, b = np.array((1.0, -2.0, 3.0)), np.array((0.5, 0.25, 2.0))
    assert between(a, compose(a, b)) == pytest.approx(b)
    assert from_frame(to_frame(ROOM_M, a), a) == pytest.approx(ROOM_M)
    assert half_turn_rad(3.0 * math.pi) == pytest.approx(-math.pi)


def test_a_coarse_level_bounds_every_block_of_the_finest() -> None:
    field = LikelihoodField(ROOM_M, 0.06, 0.10, 4)
    cells = CHANCE.integers(-20, 220, (200, 2))
    for level in range(4):
        block = range(1 << level)
        inside = [field.at(0, cells + np.array(one)) for one in itertools.product(block, block)]
        assert (field.at(level, cells) == np.max(inside, axis=0)).all()


def test_the_search_finds_the_best_of_all_poses_of_the_window() -> None:
    seen = seen_from(np.array((2.3, 1.6, 0.9)))[::6]
    headings = 0.9 + np.radians(np.arange(-4.0, 4.1, 2.0))
    low, high = np.array((1.7, 1.2)), np.array((2.9, 2.4))
    field = LikelihoodField(ROOM_M, 0.06, 0.10, 4)
    (best,) = search(field, seen, low, high, headings, 0.1)
    every = [
        field.at(0, field.cells(low + to_frame(seen, np.array((0, 0, h)))) + np.array(shift)).mean()
        for h in headings
        for shift in itertools.product(range(21), range(21))
    ]
    assert best.score == pytest.approx(max(every), abs=1e-6)
    assert best.pose == pytest.approx((2.3, 1.6, 0.9), abs=0.06)


def test_in_a_field_of_noise_nothing_is_found_and_no_memory_taken() -> None:
    """A photo that somebody took for a map: every pose is as good as any other."""
    noise = CHANCE.uniform(0.0, 30.0, (30_000, 2))
    field = LikelihoodField(noise, 0.05, 0.10, 5)
    headings = np.radians(np.arange(0.0, 360.0, 4.0))
    seen = seen_from(POSE)[::12]
    tracemalloc.start()
    assert search(field, seen, field.low_m, field.high_m, headings, 0.1, ratio=0.7) == []
    assert tracemalloc.get_traced_memory()[1] < 400e6
    tracemalloc.stop()


def test_nothing_fits_where_nothing_is_alike() -> None:
    seen = CHANCE.uniform(-3.0, 3.0, (60, 2))
    field = LikelihoodField(ROOM_M, 0.06, 0.10, 4)
    low = POSE[:2] - 0.5
    assert search(field, seen, low, low + 1.0, np.zeros(1), 0.6) == []


def test_places_that_look_the_same_are_all_named() -> None:
    square = np.array([(x, y) for x in np.arange(-1, 1, 0.05) for y in (-1.0, 1.0)])
    square = np.concatenate((square, square[:, ::-1]))
    known = np.concatenate((square, square + np.array((5.0, 0.0))))
    field = LikelihoodField(known, 0.06, 0.10, 4)
    low, high = np.array((-1.0, -1.0)), np.array((6.0, 1.0))
    found = search(field, square, low, high, np.zeros(1), 0.5, 0.5, 0.95)
    assert sorted(round(float(one.pose[0])) for one in found) == [0, 5]


def test_the_fine_fit_is_right_within_a_centimetre() -> None:
    true = np.array((2.2, 1.7, 0.8))
    seen = seen_from(true)
    grid = ndt.NdtGrid(ROOM_M)
    start = true + np.array((0.06, -0.05, math.radians(2.0)))
    found = ndt.fit(grid, seen, start)
    assert found.pose[:2] == pytest.approx(true[:2], abs=0.01)
    assert found.pose[2] == pytest.approx(true[2], abs=math.radians(0.3))
    assert found.score > 0.8
    held = ndt.fit(grid, seen, start, np.full(3, 1e-6))
    assert held.pose == pytest.approx(start, abs=1e-3)


def test_a_corridor_determines_its_width_only() -> None:
    along = np.arange(-6.0, 6.0, 0.02)
    walls = np.concatenate([np.stack((along, np.full_like(along, y)), 1) for y in (-0.7, 0.7)])
    walls += CHANCE.normal(0.0, 0.005, walls.shape)
    information = ndt.fit(ndt.NdtGrid(walls), walls, np.zeros(3)).information
    assert information[0, 0] < 0.08 * information[1, 1]
