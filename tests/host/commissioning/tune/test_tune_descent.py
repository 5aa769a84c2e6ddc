"""The descent: to the lowest point within bounds, past wrong data and idle unknowns."""

from __future__ import annotations

import numpy as np
import pytest

from gazechair.base.arrays import FloatArray
from gazechair.commissioning.tune.descent import Bounds, descend

WIDE = Bounds(np.full(2, -100.0), np.full(2, 100.0), np.ones(2))


def banana(at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rosenbrock's valley, lowest at (1, 1)."""
    x, y = at
    residual = np.array([10.0 * (y - x * x), 1.0 - x])
    return residual, np.array([[-20.0 * x, 10.0], [-1.0, 0.0]])


def test_it_follows_a_bent_valley_to_its_end() -> None:
    valley = descend(banana, 0, np.array([-1.2, 1.0]), WIDE, 200)
    assert valley.at == pytest.approx([1.0, 1.0], abs=1e-3)
    assert valley.cost == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize("start", [(-1.2, 1.0), (0.4, -3.0), (-5.0, 8.0)])
def test_on_a_bound_the_others_make_the_best_of_it(start: tuple[float, float]) -> None:
    bounds = Bounds(np.array([-100.0, -100.0]), np.array([0.5, 100.0]), np.ones(2))
    valley = descend(banana, 0, np.array(start), bounds, 200)
    assert valley.at == pytest.approx([0.5, 0.25], abs=1e-3)


def test_a_step_that_would_leave_the_bounds_is_the_best_one_within() -> None:
    squares = np.array([[2.0, 1.0], [1.0, 2.0]])
    down = np.array([5.0, 1.0])  # free: (3, -1)
    bounds = Bounds(np.array([-9.0, -9.0]), np.array([1.0, 9.0]), np.ones(2))
    assert bounds.step(np.zeros(2), squares, down) == pytest.approx([1.0, 0.0])


def test_wrong_data_pull_little_and_beliefs_in_full() -> None:
    wanted = np.array([1.0, 1.1, 0.9, 1.0, 50.0])

    def look(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.append(at[0] - wanted, at[0]), np.ones((6, 1))

    one = Bounds(np.array([-100.0]), np.array([100.0]), np.ones(1))
    robust = descend(look, 5, np.array([20.0]), one, 100).at[0]
    assert robust == pytest.approx(
        (4.0 + 2.0) / 5.0, abs=0.02
    )  # four data, one that lies, a belief
    assert descend(look, 0, np.array([20.0]), one, 100).at[0] == pytest.approx(54.0 / 6.0, abs=0.02)


def test_an_unknown_that_hardly_matters_here_does_not_take_the_step() -> None:
    # Its slope is nothing where it starts, and steep a little further: the end of a half cosine.
    def look(at: FloatArray) -> tuple[FloatArray, FloatArray]:
        x, share = at
        swing = 0.5 * (1.0 - np.cos(np.pi * share))
        residual = np.array([300.0 * (x - 1.0), 200.0 * (x + swing - 1.001)])
        steep = 100.0 * np.pi * np.sin(np.pi * share)
        return residual, np.array([[300.0, 0.0], [200.0, steep]])

    bounds = Bounds(np.array([-9.0, 0.0]), np.array([9.0, 1.0]), np.array([0.3, 0.5]))
    valley = descend(look, 0, np.array([0.0, 1e-4]), bounds, 20)
    assert valley.cost < 0.1
    assert valley.at[0] == pytest.approx(1.0, abs=0.01)
