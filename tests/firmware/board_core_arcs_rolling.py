# Driving and turning at once while the chair rolls on, and what the driver is told of it.

from gazelink import arcs, codes
from gazesim.core_rig import Core
from obstaclerig import TURN_MS, Stick


def test_a_reversed_stick_needs_both_sides():
    for linear, turn, side in ((600, 600, 0), (-600, 600, 1)):
        stick = Stick(linear, turn)
        stick.rows(arcs.BOTH_AT, arcs.SIDES * arcs.BOTH_ROWS, 0)
        stick.run(600)
        assert not stick.blocked()
        stick.push(linear, -turn)
        stick.tick()
        assert stick.blocked()
        free = Stick(linear, turn)
        free.rows(arcs.BOTH_AT + (1 - side) * arcs.BOTH_ROWS, arcs.BOTH_ROWS, 0)
        free.run(600)
        free.push(linear, -turn)
        free.run(600)
        assert not free.blocked()


def test_a_stick_pulled_back_needs_the_front_and_the_rear():
    for near in range(arcs.SIDES):
        stick = Stick(600, 400)
        stick.rows(arcs.BOTH_AT + near * arcs.BOTH_ROWS, arcs.BOTH_ROWS, 0)
        stick.run(600)
        assert not stick.blocked()
        stick.push(-600, 400)
        stick.tick()
        assert stick.blocked()


def test_a_motion_that_continues_counts_with_the_next_command():
    # Straight on while the chair still turns left, and a turn while it still rolls.
    for first, then, verb in (
        ((0, 1000), (1000, 0), codes.FORWARD),
        ((1000, 0), (0, 1000), codes.LEFT),
        ((0, 1000), (1000, 0), codes.DRIVE),
        ((1000, 0), (0, 1000), codes.DRIVE),
    ):
        stick = Stick(*first)
        stick.quadrant(0, 0)
        stick.run(600)
        assert not stick.blocked()
        stick.push(then[0], then[1], verb)
        stick.tick()
        assert stick.blocked()
        stick.push(0, 0, codes.STOP)
        stick.run(6000)
        stick.push(then[0], then[1], verb)
        stick.tick()
        assert not stick.blocked()


def test_a_bypass_waits_while_the_chair_is_faster_than_creep():
    for linear, turn in ((600, 100), (-600, 100), (600, -100)):
        stick = Stick(linear, turn)
        stick.run(600)
        for quadrant in range(4):
            stick.quadrant(quadrant, 0)
        stick.hold_bypass(1)
        # It takes some turns until its speed is that of what is put out.
        stick.run(2 * TURN_MS)
        assert stick.o.bypass.left_ms and stick.blocked(), (linear, turn)
        for _ in range(40):
            stick.hold_bypass(1)
            stick.run(100)
        assert not stick.blocked(), (linear, turn)


def test_a_reversed_stick_is_as_fast_as_both_sides_allow():
    for linear, turn in ((100, 400), (-100, 400)):
        levels = []
        for way in range(60, -1, -1):
            stick = Stick(linear, turn)
            stick.run(600)
            # One side stays free.
            stick.rows(arcs.BOTH_AT, arcs.BOTH_ROWS, arcs.FAR)
            stick.rows(arcs.BOTH_AT + arcs.BOTH_ROWS, arcs.BOTH_ROWS, way)
            stick.push(-6 * linear, turn)
            stick.tick()
            levels.append(-1 if stick.blocked() else stick.caps()[0])
            if stick.blocked():
                assert stick.caps() == (0, 0)
        assert levels == sorted(levels, reverse=True)
        assert levels[0] == 600 and levels[-1] == -1
        assert len(set(levels)) > 5, levels


# A core whose command needs an arc that is not free any more.
def near(linear, turn):
    core = Core()
    core.arm()
    core.i.linear_permille = linear
    core.i.turn_permille = turn
    core.press(codes.DRIVE)
    core.run(600)
    assert (core.motion.linear_permille, core.motion.turn_permille) == (linear, turn)
    core.i.clearance_arcs = bytearray(arcs.SIZE)
    return core


def test_p5_an_arc_ends_for_the_side_to_which_it_leads():
    for linear, turn, reason in (
        (300, 300, codes.OBSTACLE_LEFT),
        (-300, 300, codes.OBSTACLE_LEFT),
        (300, -300, codes.OBSTACLE_RIGHT),
        (-300, -300, codes.OBSTACLE_RIGHT),
    ):
        core = near(linear, turn)
        core.tick()
        assert not core.moving()
        assert core.safety.override == reason


def test_p5_what_rolls_on_ends_the_next_press_for_its_own_direction():
    for verb, linear, turn, reason in (
        (codes.FORWARD, 0, 0, codes.OBSTACLE_FORWARD),
        (codes.BACKWARD, 0, 0, codes.OBSTACLE_BACKWARD),
        (codes.LEFT, 0, 0, codes.OBSTACLE_LEFT),
        (codes.RIGHT, 0, 0, codes.OBSTACLE_RIGHT),
        (codes.DRIVE, 300, 0, codes.OBSTACLE_FORWARD),
        (codes.DRIVE, -300, 0, codes.OBSTACLE_BACKWARD),
        (codes.DRIVE, 0, 300, codes.OBSTACLE_LEFT),
        (codes.DRIVE, 0, -300, codes.OBSTACLE_RIGHT),
    ):
        core = near(500, 500)
        core.i.linear_permille = linear
        core.i.turn_permille = turn
        core.press(verb)
        core.tick()
        assert not core.moving()
        assert core.safety.override == reason, verb


def test_what_one_direction_takes_is_taken_from_both_axes():
    for near_at, way, asked, turned in ((0, 420, 600, 300), (2, 250, 300, 500)):
        for sign in (1, -1):
            core = Core()
            core.arm()
            core.i.linear_permille = asked
            core.i.turn_permille = sign * turned
            if near_at == 0:
                core.i.clearance_forward_mm = way
            else:
                core.i.clearance_left_q4 = core.i.clearance_right_q4 = way
            core.run(400)
            core.press(codes.DRIVE)
            core.run(50)
            linear, turn = core.motion.linear_permille, core.motion.turn_permille
            assert 0 < linear < asked
            assert abs(linear * turned - abs(turn) * asked) <= 600
            assert (turn > 0) == (sign > 0)


def test_a_single_axis_is_capped_while_the_other_rolls_on():
    for first, verb in (((0, 500), codes.FORWARD), ((300, 0), codes.LEFT)):
        core = Core()
        core.arm()
        core.i.linear_permille, core.i.turn_permille = first
        core.press(codes.DRIVE)
        core.run(600)
        for row in range(arcs.ROWS):
            near = row > 4 if verb == codes.LEFT else True
            core.i.clearance_arcs[row] = 45 if verb == codes.FORWARD else 0 if near else arcs.FAR
        core.press(verb)
        core.tick()
        out = max(core.motion.linear_permille, core.motion.turn_permille)
        assert 0 < out < 500, (verb, out)
