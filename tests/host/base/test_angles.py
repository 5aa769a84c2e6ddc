"""Angles wrapped to one turn: the same bits as numpy's remainder, for any input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.base.angles import in_turn, wrapped

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
    assert wrapped(within, turn).tobytes() == (within % turn).tobytes()
