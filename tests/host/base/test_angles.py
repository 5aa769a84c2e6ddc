"""Angles brought into one turn: the same bits as numpy's remainder, whatever comes in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazechair.base.angles import in_turn

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
