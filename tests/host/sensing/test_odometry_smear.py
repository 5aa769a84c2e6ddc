"""What is remembered is forgotten once it is smeared along a direction that was open."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazechair.sensing.odometry.apart import Constraints
from gazechair.sensing.odometry.local_map import LocalMap, layers_of
from gazechair.sensing.odometry.match import ERROR, FORWARD, STATES, Fit
from gazechair.sensing.odometry.smear import Smear

ALONG, STEP_S = np.array((1.0, 0.0)), 0.05


def told(strength: float) -> Constraints:
    """Something that faces along the corridor, 1/m^2, and its walls."""
    rows, places = np.array(((1.0, 0.0), (0.0, 1.0))), np.zeros((2, 2))
    return Constraints(rows, places, np.array((strength, 1e5)))


def fitted(speed_sigma_m_s: float, is_open: bool = True, error_deg: float = 0.0) -> Fit:
    state, covariance = np.zeros(STATES), np.zeros((STATES, STATES))
    state[ERROR], covariance[FORWARD, FORWARD] = math.radians(error_deg), speed_sigma_m_s**2
    axes = (ALONG,) if is_open else ()
    return Fit(state, covariance, np.eye(2), 1.0, 1.0, told(0.0), not is_open, axes)


def forgets_after_s(found: Fit, strength: float, seconds: float = 5.0) -> float | None:
    smear = Smear()
    for step in range(round(seconds / STEP_S)):
        if smear.take(STEP_S * step, found, [told(strength)]):
            return STEP_S * step
    return None


@pytest.mark.parametrize(("sigma_m_s", "after_s"), [(0.2, 0.5), (0.05, 2.0), (0.01, None)])
def test_the_less_sure_the_speed_is_the_sooner_it_forgets(
    sigma_m_s: float, after_s: float | None
) -> None:
    assert forgets_after_s(fitted(sigma_m_s), 200.0) == pytest.approx(after_s, abs=1.1 * STEP_S)


def test_it_forgets_nothing_where_nothing_tells_the_place_along() -> None:
    assert forgets_after_s(fitted(0.2), 100.0) is None


def test_it_forgets_nothing_where_no_direction_was_open() -> None:
    assert forgets_after_s(fitted(0.2, is_open=False), 5000.0) is None


def test_it_forgets_nothing_that_shows_a_lidar_that_was_bumped() -> None:
    assert forgets_after_s(fitted(0.2, error_deg=0.3), 200.0) is None
    smear = Smear()
    for step in range(40):
        assert not smear.take(STEP_S * step, fitted(0.2, error_deg=0.3), [told(200.0)])
    calm = [smear.take(2.0 + STEP_S * step, fitted(0.2), [told(200.0)]) for step in range(20)]
    assert calm.index(True) in range(3, 8)


def test_what_was_seen_before_is_forgotten_and_what_is_seen_then_counts_at_once() -> None:
    surfaces, points = LocalMap(0.1), np.array(((1.02, 2.03), (1.04, 2.05)))
    layers = layers_of(np.tile(ALONG, (2, 1)))

    def known() -> list[float]:
        counts: list[float] = surfaces.look_up(points, layers)[0][:, 0].tolist()
        return counts

    for at_s in (5.0, 5.1, 6.0):
        surfaces.insert(points, layers, at_s)
    assert known() == [6.0, 6.0]
    surfaces.begin_anew(6.5)
    assert known() == [0.0, 0.0]
    surfaces.insert(points, layers, 6.5)
    assert known() == [2.0, 2.0]
    elsewhere = points + np.array((1.0, 0.0))  # later ones must be seen twice
    surfaces.insert(elsewhere, layers, 8.0)
    assert surfaces.look_up(elsewhere, layers)[0][:, 0].tolist() == [0.0, 0.0]
