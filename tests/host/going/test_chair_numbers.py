"""What the planner knows of a chair whose outputs are limited, and how its model moves."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.going.chair_numbers import AxisModel, ChairNumbers
from gazechair.going.follow import PERIOD_S
from gazelink.settings_table import TABLE
from gazesim.chair import Chair, Disturbances
from gazesim.profiles import PROFILES
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


def test_the_model_takes_as_long_as_the_periods_that_it_is_told_of() -> None:
    of = numbers()
    model = replace(of, dead_s=1.0).turn_axis()
    for _ in range(20):
        model.put_out(of.spot_permille, PERIOD_S)
    assert model.speed == 0.0
    model.put_out(of.spot_permille, PERIOD_S)
    assert model._ramp > 0.0


def test_the_model_alone_moves_as_the_twin_does_on_a_level_floor() -> None:
    of = numbers()
    turns, drives = of.spot_permille, of.linear_permille(0.3)
    for n in (12, 14):
        chair = undisturbed(n, (0, turns))
        assert after(of.turn_axis(), n, turns) == pytest.approx(chair.yaw_rate_deg_s, abs=0.5)
        chair = undisturbed(n, (drives, 0))
        assert after(of.linear_axis(), n, drives) == pytest.approx(chair.speed_m_s, abs=0.01)


def after(model: AxisModel, periods: int, permille: int) -> float:
    """The model's speed after some periods at an output, from rest."""
    for _ in range(periods):
        model.put_out(permille, PERIOD_S)
    return model.speed


def undisturbed(periods: int, stick: tuple[int, int]) -> Chair:
    """The twin after the same."""
    chair = Chair(parameters=replace(PROFILES["3.1"], disturbances=Disturbances()))
    chair.step(0.01, (0.0, 0.0))
    for _ in range(5 * periods):
        chair.step(0.01, (stick[0] / 1000.0, stick[1] / 1000.0))
    return chair
