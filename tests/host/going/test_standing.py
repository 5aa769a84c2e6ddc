"""What the board may take for a standing person, in a map; paths that head for it cost more."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gazeboard.io.settings import Settings
from gazechair.base.footprint import Footprint
from gazechair.going.plan import Path, Planner
from gazechair.going.standing import PATIENCE_S, STOPS_M, WAITS_S, Ahead, standing_m
from gazechair.sensing.clearance.standing import Approach
from gazechair.sensing.clearance.stood import CALM_S
from gazelink import codes
from gazelink.settings_table import PROFILES
from gazesim.zone import zone_of
from goingrig import CELL_M, Box, floor

WALL: Box = (3.95, 0.0, 4.05, 2.5)
STOOL: Box = (6.0, 1.8, 6.3, 2.1)


def cells_of(*boxes: Box) -> np.ndarray:
    found = np.zeros((320, 160), dtype=np.bool_)
    for x0, y0, x1, y1 in boxes:
        found[round(x0 / CELL_M) : round(x1 / CELL_M), round(y0 / CELL_M) : round(y1 / CELL_M)] = 1
    return found


def test_a_stool_is_one_a_wall_a_leg_and_a_cupboard_are_none() -> None:
    leg, cupboard = (1.0, 1.0, 1.05, 1.05), (2.0, 3.0, 2.5, 3.9)
    found = standing_m(cells_of(WALL, leg, cupboard, STOOL), CELL_M, np.array((10.0, 0.0)))
    assert found.min(axis=0) == pytest.approx((16.0 + CELL_M / 2, 1.8 + CELL_M / 2))
    assert found.max(axis=0) == pytest.approx((16.3 - CELL_M / 2, 2.1 - CELL_M / 2))
    assert not len(standing_m(cells_of(WALL, leg, cupboard), CELL_M, np.zeros(2)))


@pytest.mark.parametrize("profile", range(len(PROFILES)))
def test_it_stops_the_chair_where_the_clearance_does_and_as_long(profile: int) -> None:
    settings = Settings()
    settings.profile = profile
    approach = Approach(zone_of(settings).of(codes.DIR_FORWARD))
    assert 0.0 <= STOPS_M - approach.blocked_within_m < 0.1
    assert CALM_S < WAITS_S < PATIENCE_S


def test_what_touches_a_wall_is_a_part_of_it() -> None:
    beside = (4.05 + CELL_M, 1.0, 4.4, 1.3)
    assert not len(standing_m(cells_of(WALL, beside), CELL_M, np.zeros(2)))


@pytest.mark.parametrize(
    ("a", "b", "backward", "costs"),
    [
        ((2.0, 2.0), (5.0, 2.0), False, True),  # its end is 0.35 m before the stool
        ((2.0, 2.0), (4.4, 2.0), False, False),
        ((2.0, 1.3), (7.5, 1.3), False, False),  # past it
        ((2.0, 1.45), (7.5, 1.45), False, True),
        ((7.9, 2.0), (6.9, 2.0), True, True),
        ((6.9, 2.0), (7.9, 2.0), False, False),  # away from it
    ],
)
def test_a_leg_that_heads_for_one_costs_what_waiting_does(
    a: tuple[float, float], b: tuple[float, float], backward: bool, costs: bool
) -> None:
    things = standing_m(cells_of(STOOL), CELL_M, np.zeros(2))
    seconds = Ahead(Footprint()).leg_s(things, np.array(a), np.array(b), backward)
    assert (seconds > WAITS_S) is costs
    assert costs or seconds == 0.0


def test_a_way_round_a_stool_keeps_off_what_is_before_it() -> None:
    costmap = floor((STOOL,))
    path = Planner(costmap).plan((1.0, 2.0, 0.0), (5.2, 1.0, math.pi / 2))
    assert isinstance(path, Path)
    legs = zip(path.points_m[:-1], path.points_m[1:], strict=True)
    assert sum(costmap.ahead.leg_s(costmap.standing_m, a, b, False) for a, b in legs) == 0.0


def test_what_is_seen_now_counts_as_well() -> None:
    costmap = floor()
    assert not len(costmap.standing_m)
    around = np.array([(6.0 + 0.01 * n, 1.8) for n in range(30)])
    costmap.see(around, 1.0, (5.0, 2.0))
    costmap.refresh(1.0)
    assert len(costmap.standing_m) > 5
    costmap.refresh(60.0)
    assert not len(costmap.standing_m)
