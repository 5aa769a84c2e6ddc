"""The benchmark of going somewhere: one mission judged by the truth, and the ideal time."""

from __future__ import annotations

import math

import numpy as np

from gazechair.going.chair_numbers import CAP_M_S
from gazechair.going.plan import Way
from gazemeasure.go_ideal import Permitted, ideal_s
from gazemeasure.go_missions import DOORS, Job, mission
from gazemeasure.turn_board import settings_with
from goingrig import numbers


def test_a_mission_is_judged_by_the_truth() -> None:
    found = mission(Job(DOORS, 2))
    assert found.collisions == 0
    assert found.arrived, found.why
    assert found.least_m > 0.0


def test_the_ideal_is_the_way_at_the_permitted_speed_and_its_turns() -> None:
    full = {"profile": 2, "linear_permille": 1000, "turn_permille": 1000}
    permitted = Permitted(settings_with(full), numbers(), False)
    assert 0.15 < permitted.m_s <= CAP_M_S
    assert 15.0 < permitted.deg_s < numbers().left_deg_s
    straight = Way(np.array(((0.0, 0.0), (3.5, 0.0))), None)
    way_s = 3.5 / permitted.m_s
    assert ideal_s(straight, (0.0, 0.0, 0.0), permitted) == way_s
    turned = ideal_s(straight, (0.0, 0.0, math.pi / 2), permitted)
    assert way_s + 90.0 / permitted.deg_s < turned < way_s + 90.0 / permitted.deg_s + 3.0
