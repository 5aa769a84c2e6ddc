# Driving and turning at once: what the clearance's rows leave of a command.

from board_core_obstacles import TURN_MS, Eyes
from corerig import Core
from gazeboard.core import limits
from gazeboard.core.obstacles import ARC_BLOCKED
from gazelink import arcs, codes

QUADRANTS = ((300, 200), (-300, 200), (300, -200), (-300, -200))


# The board with a stick that is held, both its axes put out as asked while nothing blocks.
class Stick(Eyes):
    def __init__(self, linear=0, turn=0, verb=codes.DRIVE):
        super().__init__()
        self.i.cap_permille = 1000
        self.push(linear, turn, verb)

    def push(self, linear, turn, verb=codes.DRIVE):
        self.i.verb = verb
        self.i.linear_permille = linear
        self.i.turn_permille = turn

    # Puts out what is asked for, as the motion does.
    def tick(self):
        super().tick()
        arcs_ = self.o.arcs
        moves = not self.blocked()
        self.linear = within(self.i.linear_permille, arcs_.linear_cap) if moves else 0
        self.turn = within(self.i.turn_permille, arcs_.turn_cap) if moves else 0

    def blocked(self):
        assert self.o.arcs.blocked == (self.o.blocked & ARC_BLOCKED != 0)
        return self.o.arcs.blocked

    def caps(self):
        return (self.o.arcs.linear_cap, self.o.arcs.turn_cap)

    def rows(self, at, count, units):
        for row in range(at, at + count):
            self.i.clearance_arcs[row] = units

    def quadrant(self, quadrant, units):
        self.rows(quadrant * arcs.ROWS, arcs.ROWS, units)


def within(value, cap):
    return max(-cap, min(cap, value))


def test_nothing_near_limits_nothing():
    for linear, turn in QUADRANTS:
        stick = Stick(linear, turn)
        stick.run(400)
        assert not stick.blocked()
        assert stick.caps() == (abs(linear), abs(turn))


def test_each_quadrant_has_its_rows():
    for near in range(4):
        for at in range(4):
            stick = Stick(*QUADRANTS[at])
            stick.quadrant(near, 0)
            stick.run(2 * TURN_MS)
            assert stick.blocked() == (near == at), (near, at)
            assert stick.o.blocked & 15 == 0


def test_nothing_is_put_out_before_it_has_been_judged():
    for linear, turn in QUADRANTS:
        for ahead_ms in range(TURN_MS):
            stick = Stick()
            for quadrant in range(4):
                stick.quadrant(quadrant, 0)
            stick.run(ahead_ms)
            stick.push(linear, turn)
            for _ in range(3 * TURN_MS):
                stick.tick()
                assert stick.linear == stick.turn == 0
            assert stick.blocked()


def test_a_command_is_judged_in_its_tick():
    for ahead_ms in range(20):
        stick = Stick()
        stick.run(ahead_ms)
        stick.push(300, 200)
        stick.tick()
        assert (stick.linear, stick.turn) == (300, 200)


def test_one_axis_alone_is_not_judged():
    for linear, turn in ((1000, 0), (-1000, 0), (0, 1000), (0, -1000)):
        stick = Stick(linear, turn)
        for quadrant in range(4):
            stick.quadrant(quadrant, 0)
        stick.rows(arcs.BOTH_AT, arcs.SIDES * arcs.BOTH_ROWS, 0)
        stick.run(600)
        assert not stick.blocked()
        assert stick.caps() == (1000, 1000)


def test_a_new_clearance_too_near_blocks_in_its_tick():
    stick = Stick(300, 200)
    stick.run(300)
    for _ in range(40):
        stick.run(1)
        trial = Stick(300, 200)
        trial.run(stick.now_ms)
        trial.frames = False
        trial.quadrant(0, 0)
        trial.frame()
        assert not trial.blocked()
        trial.tick()
        assert trial.blocked()


def test_the_way_counts_at_the_turn_it_takes_to_stop():
    # What the chair turns and travels until it stands, from the ways; the first row that holds it.
    for linear, turn in ((300, 100), (300, 400), (1000, 1000), (500, 150)):
        stick = Stick(linear, turn)
        stick.run(600)
        stop_mm = stick.way(0).stop
        stop_q4 = stick.way(2).stop
        row = [16 * deg > stop_q4 for deg in arcs.TURNS_DEG].index(True)
        need = stop_mm // arcs.UNIT_MM + 1
        stick.rows(0, row, 0)  # smaller turns do not matter: they cannot be less than greater ones
        stick.rows(row, 1, need + 1)
        stick.rows(row + 1, arcs.ROWS - row - 1, 0)
        stick.frame()
        stick.tick()
        assert not stick.blocked(), (linear, turn)
        stick.rows(row, 1, need - 1)
        stick.frame()
        stick.tick()
        assert stick.blocked(), (linear, turn)


def test_slowed_down_both_axes_keep_their_proportion():
    for linear, turn in ((1000, 500), (600, 600), (400, 1000)):
        seen = set()
        for units in range(20, 140, 4):
            stick = Stick(linear, turn)
            for quadrant in range(4):
                stick.quadrant(quadrant, units)
            stick.run(600)
            if stick.blocked():
                continue
            linear_cap, turn_cap = stick.caps()
            asked = (min(600, linear), min(500, turn))  # as far as the settings let it
            assert abs(linear_cap * asked[1] - turn_cap * asked[0]) <= 1000, stick.caps()
            seen.add(linear_cap)
        assert len(seen) > 4


def test_more_only_after_300_ms_of_a_better_view():
    stick = Stick(600, 300)
    stick.quadrant(0, 35)
    stick.run(100)
    slow = stick.caps()
    assert 0 < slow[0] < 600
    stick.quadrant(0, arcs.FAR)
    stick.run(limits.CLEAR_MS - 2 * TURN_MS)
    assert stick.caps() == slow
    stick.run(60)
    assert stick.caps() == (600, 300)


def test_an_old_clearance_is_shortened_by_what_the_chair_moved():
    stick = Stick(500, 200)
    stick.run(500)
    stick.frames = False
    stick.quadrant(0, stick.way(0).stop // arcs.UNIT_MM + 4)
    stick.frame()
    stick.tick()
    assert not stick.blocked()
    stick.run(250)
    assert stick.blocked()


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


def test_what_rolls_on_counts_with_the_next_command():
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


def test_holding_the_heading_is_no_arc():
    stick = Stick(1000, 0, codes.FORWARD)
    for quadrant in range(4):
        stick.quadrant(quadrant, 0)
    for turn in (150, -150):
        for _ in range(800):
            stick.tick()
            stick.turn = turn
        assert not stick.blocked()


def test_blind_blocks_and_unseen_creeps():
    for quadrant in range(4):
        for at in range(4):
            linear, turn = QUADRANTS[at]
            blind = Stick(2 * linear, 2 * turn)
            blind.i.clearance_arc_views = 1 << quadrant
            blind.run(2 * TURN_MS)
            assert blind.blocked() == (quadrant == at)
            unseen = Stick(2 * linear, 2 * turn)
            unseen.i.clearance_arc_views = 16 << quadrant
            unseen.run(2 * TURN_MS)
            assert not unseen.blocked()
            assert (unseen.caps()[0] < abs(linear)) == (quadrant == at)


def test_a_bypass_creeps_once_it_is_slow():
    stick = Stick(600, 300)
    stick.quadrant(0, 0)
    stick.run(40)
    assert stick.blocked()
    stick.hold_bypass(1)
    stick.run(3 * TURN_MS)
    assert not stick.blocked()
    linear_cap, turn_cap = stick.caps()
    assert 0 < linear_cap <= stick.stopping(0).permille[0]
    assert 0 < turn_cap <= stick.stopping(2).permille[0]


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


def test_a_stick_that_is_turned_about_is_as_fast_as_both_sides_leave():
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


def test_a_turn_beyond_the_widest_row_is_blocked():
    stick = Stick(300, 300)
    stick.run(300)
    stick.i.rate_q4 = 16 * 100
    stick.run(2 * TURN_MS)
    assert stick.blocked()


def test_settings_and_cap_limit_what_is_judged():
    stick = Stick(1000, 1000)
    stick.i.cap_permille = 100
    stick.run(300)
    assert stick.caps() == (100, 100)
    stick.i.cap_permille = 1000
    stick.run(400)
    assert stick.caps() == (600, 500)


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


def test_a_clearance_in_every_tick_keeps_no_turn_of_the_arcs_waiting():
    slowed = 0
    for units in range(0, 200, 8):
        left = []
        for news in (0, 1):
            stick = Stick(300, 200)
            stick.run(400)
            stick.quadrant(0, units)
            stick.i.clearance_count += 1
            for _ in range(8 * TURN_MS):
                stick.tick()
                stick.i.clearance_count += news
            left.append(stick.caps())
        assert left[0] == left[1], (units, left)
        slowed += 0 < left[0][0] < 300
    assert slowed
