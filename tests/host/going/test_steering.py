"""Steering: none where straight ahead is enough, and none against an unfinished turn."""

from __future__ import annotations

import math

import pytest

from gazechair.going.chair_numbers import ChairNumbers
from gazechair.going.steering import Steering
from goingrig import numbers


@pytest.mark.parametrize(
    ("room_m", "straight_m", "across", "steers"),
    [
        (0.5, 0.5, 0.03, True),
        (0.10, 0.10, 0.03, False),  # the board would only let it creep
        (0.10, 0.10, 0.06, True),
        (0.10, 0.04, 0.03, True),  # there is hardly room straight ahead
        (0.05, 0.02, 0.06, False),
    ],
)
def test_where_it_is_narrow_it_steers_only_when_it_must(
    room_m: float, straight_m: float, across: float, steers: bool
) -> None:
    made = numbers()
    steering = Steering(made, made.turn_axis())
    asked = steering.straight(across, 0.0, 2.0, room_m, straight_m)
    assert (asked < 0) is steers


def turning(made: ChairNumbers, rate_deg_s: float) -> Steering:
    axis = made.turn_axis()
    axis.speed = rate_deg_s
    return Steering(made, axis)


def test_a_turn_is_not_reversed_before_it_is_over() -> None:
    made = numbers()
    error = math.radians(-5.0)
    assert turning(made, 10.0).curved(0.0, 0.0, error) == 0
    assert turning(made, 10.0).straight(0.0, error, 2.0, 0.5, 0.5) == 0
    assert turning(made, 2.0).curved(0.0, 0.0, error) < 0
    assert turning(made, -10.0).curved(0.0, 0.0, error) < 0
