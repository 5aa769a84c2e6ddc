"""Requests in vain: what the board refuses only while the chair may still roll is not given up."""

from __future__ import annotations

import math

import pytest

from gazechair.going.follow import STOP
from gazechair.going.mission import ARRIVED
from gazechair.going.pace import PERIOD_S
from goingrig import GoingChair, floor

pytestmark = pytest.mark.costly

HALL = (10.0, 5.0)


@pytest.mark.parametrize("refused_s", [1.1, 1.5, 1.8])
def test_a_turn_is_requested_until_the_board_is_sure_that_the_chair_stands(
    refused_s: float,
) -> None:
    """Beside things it permits none before that: 1.8 s after the last output at most."""
    chair = GoingChair(floor((), HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(8.0)
    chair.mission.go((1.0, 2.0, math.pi))
    while chair.step().linear_permille:
        assert chair.now_s < 9.0
    begin_s, chair.refuses = chair.now_s, True
    while chair.now_s < begin_s + refused_s:
        chair.step()
    assert chair.mission._recovery.refused.all == ()
    chair.refuses = False
    assert chair.step() != STOP
    assert chair.run(90.0) == ARRIVED


def test_a_turn_that_is_refused_after_that_is_requested_for_moments_and_given_up() -> None:
    chair = GoingChair(floor((), HALL), (1.5, 2.0, 0.0))
    chair.mission.go((8.5, 2.0, 0.0))
    chair.run(8.0)
    chair.mission.go((1.0, 2.0, math.pi))
    while chair.step().linear_permille:
        assert chair.now_s < 9.0
    chair.refuses, asked_s = True, 0.0
    for _ in range(round(4.0 / PERIOD_S)):
        chair.step()
        asked_s += PERIOD_S * (chair.asked != STOP)
    assert any(one.turns for one in chair.mission._recovery.refused.all)
    assert asked_s < 3.0
