"""Assist without fresh scans or a heading, and after a gap in them."""

import pytest

from assistrig import before_a_door, door_room, half
from gazechair.assist.assist import Assist, _Spot
from gazechair.base.footprint import Footprint
from gazechair.board.board_commands import Clearance
from gazechair.sensing.inbox.motion import Motion
from gazelink import codes
from gazesim.rooms import Room
from gazesim.zone import zone_of


def test_it_knows_nothing_without_fresh_scans():
    assist = before_a_door(0.25)
    for k in range(30):
        assist.motion(Motion(1.1 + 0.01 * k, 0.0, 0, 0))
    assert assist.advise(1, 1.09 + 0.14) is not None
    assert assist.advise(1, 1.09 + 0.16) is None


def test_it_knows_nothing_without_a_heading():
    assist = before_a_door(0.25)
    assist.motion(Motion(1.1, None, 0, 0))
    assert assist.advise(1, 1.1) is None


def test_it_knows_nothing_while_a_lidar_is_missing():
    both = Assist(Footprint(), 2)
    both.permits.zone = zone_of()
    both.permits.clearance = Clearance(0, codes.REAL, 1.0)
    for k in range(20):
        both.motion(Motion(0.9 + 0.01 * k, 0.0, 0, 0))
    room = Room("open", ((-3.0, -4.0, -3.0, 4.0),))
    both.see(0, half(room, 1.04, 90.0))
    both.see(0, half(room, 1.09, -90.0))
    assert both.advise(1, 1.1) is None


def test_it_knows_nothing_where_a_lidar_is_blind():
    assist = before_a_door(0.25)
    assist.permits.clearance = Clearance(1 << codes.DIR_LEFT, codes.REAL, 1.0)
    assert assist.advise(1, 1.1) is None


def test_without_a_heading_nothing_is_kept_that_was_measured_from_its_zero():
    assist = before_a_door(0.25)
    assist.advise(1, 1.1)
    assist.motion(Motion(1.1, None, 0, 0))
    assert assist._press.number == 0
    assist.motion(Motion(1.11, 90.0, 0, 0))  # the sensor was reset: another zero
    assert assist.advise(1, 1.12) is None
    assist.see(0, half(door_room(-0.2, 0.7), 1.15, 90.0))
    assist.motion(Motion(1.2, 90.0, 0, 0))
    assist.see(0, half(door_room(-0.2, 0.7), 1.2, -90.0))
    assert assist.advise(1, 1.21).turn_permille > 0
    assert assist._press.pointed_deg == 90.0


def test_a_heading_lost_in_a_turn_of_the_driver_is_no_correction():
    assist = before_a_door(0.25)
    assert assist.advise(1, 1.1).steers
    for now_s, heading_deg in ((1.15, 0.0), (1.2, None), (1.25, 359.0)):
        assist.motion(Motion(now_s, heading_deg, 0, 0))
        assist.driver_turns(1, now_s)
    assert assist._own.help(1.3) == 1.0


def late_lidar(assist, asked):
    """The chair is turned by 30 degrees, then no lidar is seen for half a second, until 1.9 s."""
    assist.advise(1, 1.1)
    assist._press.spot = _Spot(40.0, 1.1)
    for k in range(80):
        assist.motion(Motion(1.11 + 0.01 * k, min(30.0, 1.0 + k), 0, 300))
    assert not asked or assist.advise(1, 1.5) is None
    assist.see(0, half(door_room(-0.2, 0.7), 1.85, 90.0))
    assist.see(0, half(door_room(-0.2, 0.7), 1.9, -90.0))


@pytest.mark.parametrize("asked", [False, True])
def test_a_gap_in_what_a_lidar_sees_does_not_change_where_the_driver_points(asked):
    assist = before_a_door(0.25)
    late_lidar(assist, asked)
    assert assist.advise(1, 1.9) is not None
    assert assist._press.pointed_deg < 10.0


@pytest.mark.parametrize("asked", [False, True])
def test_after_such_a_gap_no_turn_on_the_spot_goes_on_that_was_chosen_before_it(asked):
    assist = before_a_door(0.25)
    late_lidar(assist, asked)
    assist.advise(1, 1.9)
    assert assist._press.spot is None
