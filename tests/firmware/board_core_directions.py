# The safety core: what an obstacle or a lost heading forbids, direction by direction.

from gazeboard.core import directions
from gazeboard.core.shared import Inputs
from gazelink import codes
from gazesim.core_rig import Core, refused

REASON = codes.FAULT_REASON


def test_a_command_leads_in_the_directions_of_its_axes_and_of_both_together():
    i = Inputs()
    for verb in (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT):
        for i.linear_permille, i.turn_permille in ((0, 0), (-1, 1)):  # only a drive's count
            assert directions.heads(i, verb) == directions.ARC_BLOCKED | 1 << (verb - codes.FORWARD)
    for i.linear_permille, along in ((-1000, 2), (-1, 2), (0, 0), (1, 1), (1000, 1)):
        for i.turn_permille, aside in ((-1000, 8), (-1, 8), (0, 0), (1, 4), (1000, 4)):
            both = directions.ARC_BLOCKED if along or aside else 0
            assert directions.heads(i, codes.DRIVE) == both | along | aside


def test_p5_a_blocked_direction_refuses_what_goes_there_and_nothing_else():
    for verb, linear, turn, needs in (
        (codes.FORWARD, 0, 0, 1),
        (codes.BACKWARD, 0, 0, 2),
        (codes.LEFT, 0, 0, 4),
        (codes.RIGHT, 0, 0, 8),
        (codes.DRIVE, 2, 0, 1),
        (codes.DRIVE, 1, 0, 1),
        (codes.DRIVE, -1, 0, 2),
        (codes.DRIVE, 0, 1, 4),
        (codes.DRIVE, 0, -1, 8),
        (codes.DRIVE, 1, 1, 5),
        (codes.DRIVE, -1, -1, 10),
    ):
        core = Core()
        core.i.linear_permille = linear
        core.i.turn_permille = turn
        core.arm()
        for blocked in range(16):
            core.i.clearance_blocked = blocked
            core.see()
            core.press(verb)
            core.tick()
            against = blocked & needs
            assert core.moving() == (against == 0), (verb, blocked)
            lowest = 0
            while against >> lowest & 1 == 0 and lowest < 4:
                lowest += 1
            reason = codes.OBSTACLE_FORWARD + lowest if against else codes.NO_REASON
            assert core.safety.override == reason


def test_p5_an_obstacle_stops_the_motion_under_way_for_good():
    core = Core()
    core.drive()
    core.i.clearance_blocked = 1
    assert refused(core, codes.OBSTACLE_FORWARD)
    core.i.clearance_blocked = 0
    assert refused(core, codes.OBSTACLE_FORWARD)


def test_a_proportional_command_that_does_not_turn_needs_no_heading():
    core = Core()
    core.arm()
    core.i.heading_faults = 1 << codes.HEADING_BUS
    core.i.linear_permille = 100
    core.press(codes.DRIVE)
    core.tick()
    assert core.moving()
    core.i.turn_permille = 1
    assert refused(core, REASON + codes.HEADING_BUS)


def test_the_reason_is_the_obstacle_whatever_else_only_warns():
    core = Core()
    core.arm()
    core.i.heading_faults = 1 << codes.HEADING_JUMP
    core.i.clearance_blocked = 1
    core.press(codes.FORWARD)
    assert refused(core, codes.OBSTACLE_FORWARD)
    core.lidar = False
    core.run(400)
    core.press(codes.LEFT)
    assert refused(core, REASON + codes.HEADING_JUMP)  # without a heading first, then the data


def test_reasons_in_their_order():
    # Ownership before faults before obstacles.
    core = Core()
    core.arm()
    core.i.clearance_blocked = 15
    core.press(codes.LEFT)
    core.tick()
    assert core.safety.override == codes.OBSTACLE_LEFT
    core.i.heading_faults = 1 << codes.HEADING_JUMP
    core.press(codes.LEFT)
    core.tick()
    assert core.safety.override == REASON + codes.HEADING_JUMP
    core.i.tilted = True
    core.press(codes.LEFT)
    core.tick()
    assert core.safety.override == REASON + codes.TILT  # not the heading's, which only warns
    core.press(codes.LEFT)
    core.i.owner = codes.CARETAKER
    core.tick()
    assert core.safety.override == codes.NOT_OWNER
