"""What the planner knows of a chair whose outputs are limited."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.going.chair_numbers import CAP_M_S
from goingrig import numbers


@pytest.mark.parametrize("profile", range(3))
def test_an_output_limit_in_the_deadband_leaves_no_speed_and_none_backward(profile: int) -> None:
    full = numbers(profile)
    assert 0.0 < full.most_m_s <= CAP_M_S
    deadband = round(1000.0 * full.deadband)
    for most in (0, deadband // 2, deadband):
        limited = replace(full, linear_most=most)
        assert limited.most_m_s == pytest.approx(0.0, abs=1e-9)
        assert limited.linear_permille(min(0.0, limited.most_m_s)) == 0
    assert replace(full, linear_most=deadband + 50).most_m_s > 0.0
