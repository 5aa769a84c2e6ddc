"""What the planner knows of a chair whose outputs are limited."""

from __future__ import annotations

import math
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


@pytest.mark.parametrize("stick", [(576, 130), (576, -130), (-576, 130), (265, 367)])
@pytest.mark.parametrize("most", [150, 300, 500])
def test_within_a_limit_the_curve_stays_the_same(stick: tuple[int, int], most: int) -> None:
    chair = numbers()

    def moves(output: int) -> float:
        return math.copysign(max(0.0, abs(output) / 1000.0 - chair.deadband), output)

    linear, turn = chair.within(*stick, most)
    assert max(abs(linear), abs(turn)) <= most
    assert moves(turn) / moves(linear) == pytest.approx(moves(stick[1]) / moves(stick[0]), rel=0.05)
    assert abs(moves(linear)) <= abs(moves(stick[0]))


def test_within_a_limit_nothing_else_changes() -> None:
    chair = numbers()
    assert chair.within(300, -130, 300) == (300, -130)
    assert chair.within(0, -679, 300) == (0, -300)
    assert chair.within(1000, 0, 300) == (300, 0)
    assert chair.within(500, 20, 300) == (300, 20)  # which turns no chair
    wide = replace(chair, deadband=0.2)
    assert wide.within(500, 300, 150) == (150, 150)  # as the board does: neither moves
    assert wide.within(190, 0, 150) == (150, 0)


@pytest.mark.parametrize(
    ("settings", "cap_permille", "drives"),
    [
        ({}, 1000, True),
        ({}, 300, True),
        ({}, 250, False),  # below breakaway
        ({"turn_permille": 200}, 1000, False),
        ({"linear_permille": 50}, 1000, False),  # in the deadband
        ({"profile": 0}, 1000, True),  # to the left only
    ],
)
def test_a_limit_too_low_to_turn_or_to_drive_is_known(
    settings: dict[str, int], cap_permille: int, drives: bool
) -> None:
    known = {name: default for name, default, _, _ in TABLE} | {"profile": 2} | settings
    assert ChairNumbers.of(known).drives_within(cap_permille) is drives
