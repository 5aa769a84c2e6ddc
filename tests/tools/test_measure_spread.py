"""Spreads: percentiles that are never too good, of any values, as one or as several."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gazemeasure.spread import Spread, together

_STEP = 0.01
_VALUES = st.lists(st.floats(-4.9, 4.9), min_size=1, max_size=40)


@given(_VALUES, st.sampled_from((5.0, 50.0, 95.0, 100.0)))
def test_a_percentile_is_that_of_the_values_or_up_to_a_step_more(
    values: list[float], percent: float
) -> None:
    exact = np.percentile(np.abs(values), percent, method="inverted_cdf")
    assert exact - 1e-9 <= Spread.of(values, _STEP).percentile(percent) <= exact + _STEP + 1e-9


@given(_VALUES, _VALUES)
def test_several_are_as_one(here: list[float], there: list[float]) -> None:
    assert together((Spread.of(here, _STEP), Spread.of(there, _STEP))) == Spread.of(
        here + there, _STEP
    )


def test_what_is_farther_off_than_all_steps_counts_and_is_told() -> None:
    spread = Spread.of([0.004, 0.006, 80.0, math.inf], _STEP)
    assert spread.count == 4
    assert spread.share_below(1.0) == 0.5
    assert spread.percentile(75.0) == math.inf
    assert spread.most == math.inf


def test_nothing_has_no_percentile() -> None:
    spread = Spread.of([], _STEP)
    assert math.isnan(spread.percentile(50.0))
    assert spread.share_below(1.0) == 0.0
    assert together((spread, Spread.of([0.2], _STEP), spread)) == Spread.of([0.2], _STEP)


@pytest.mark.parametrize("step", [0.001, 0.1])
def test_a_value_on_the_edge_of_steps_is_within(step: float) -> None:
    assert Spread.of([30 * step], step).percentile(95.0) == pytest.approx(30 * step)
