"""Angles brought into one turn: the same bits as numpy's remainder, for any input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.base.angles import half_turn_deg, half_turn_rad, in_turn, in_turn_if_near

TURNS = (360.0, 2.0 * math.pi)


@given(st.lists(st.floats(allow_infinity=False)), st.sampled_from(TURNS))
def test_it_is_the_remainder(angles: list[float], turn: float) -> None:
    given_angles = np.array(angles)
    assert in_turn(given_angles, turn).tobytes() == (given_angles % turn).tobytes()


@pytest.mark.parametrize("turn", TURNS)
def test_it_is_the_remainder_at_the_ends_of_a_turn(turn: float) -> None:
    ends = np.array([-turn, -0.0, 0.0, turn, 2.0 * turn, np.nan])
    angles = np.concatenate(
        [np.nextafter(ends, -np.inf), ends, np.nextafter(ends, np.inf), -(2.0 ** -np.arange(99.0))]
    )
    assert in_turn(angles, turn).tobytes() == (angles % turn).tobytes()


@given(st.lists(st.floats(-1.0, 1.0, exclude_max=True)), st.sampled_from(TURNS))
def test_it_is_the_remainder_of_what_is_within_a_turn(shares: list[float], turn: float) -> None:
    within = np.array(shares) * turn
    within = np.concatenate(
        (within[within < turn], [-turn, -0.0, np.nextafter(turn, 0.0), -5e-324])
    )
    assert in_turn_if_near(within, turn).tobytes() == (within % turn).tobytes()


def test_half_a_turn_begins_at_its_lower_end_for_a_number_and_an_array() -> None:
    assert [half_turn_deg(deg) for deg in (-180.0, 180.0, 190.0, -190.0, 725.0)] == [
        *(-180.0, -180.0, -170.0, 170.0, 5.0)
    ]
    assert half_turn_deg(np.array([179.0, 181.0])).tolist() == [179.0, -179.0]
    assert half_turn_rad(3.0 * math.pi) == pytest.approx(-math.pi)
    assert half_turn_rad(np.array([0.5, 0.5 + 2.0 * math.pi])).tolist() == pytest.approx([0.5, 0.5])
