"""What the planner knows of a chair whose outputs are limited."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.going.chair_numbers import ChairNumbers
from gazelink.settings_table import TABLE
from goingrig import numbers


@pytest.mark.parametrize("profile", range(3))
def test_an_output_limit_in_the_deadband_leaves_no_speed_and_none_backward(profile: int) -> None:
    full = numbers(profile)
    assert 0.0 < full.most_m_s <= full.cap_m_s
    deadband = round(1000.0 * full.deadband)
    for most in (0, deadband // 2, deadband):
        limited = replace(full, linear_most=most)
        assert limited.most_m_s == pytest.approx(0.0, abs=1e-9)
        assert limited.linear_permille(min(0.0, limited.most_m_s)) == 0
    assert replace(full, linear_most=deadband + 50).most_m_s > 0.0


@pytest.mark.parametrize("mm_s", [250, 300, 350])
def test_the_board_s_limit_for_auto_motions_is_the_highest_speed(mm_s: int) -> None:
    values = {name: default for name, default, _, _ in TABLE}
    values |= {"profile": 2, "linear_permille": 1000, "auto_mm_s": mm_s}
    limited = ChairNumbers.of(values)
    assert limited.forward_m_s > 0.35
    assert limited.most_m_s == mm_s / 1000.0
