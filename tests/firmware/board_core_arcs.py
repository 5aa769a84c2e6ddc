# Driving and turning at once: what the clearance's rows leave of a command.

from gazeboard.core import limits
from gazelink import arcs, codes
from obstaclerig import TURN_MS, Stick

QUADRANTS = ((300, 200), (-300, 200), (300, -200), (-300, -200))


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


def test_a_command_of_one_axis_is_not_judged_as_an_arc():
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


def test_the_free_distance_counts_in_the_row_of_the_stopping_turn():
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


def test_more_is_allowed_only_after_300_ms_of_a_better_view():
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


def test_holding_the_heading_is_no_arc():
    stick = Stick(1000, 0, codes.FORWARD)
    for quadrant in range(4):
        stick.quadrant(quadrant, 0)
    for turn in (150, -150):
        for _ in range(800):
            stick.tick()
            stick.turn = turn
        assert not stick.blocked()


def test_a_blind_arc_blocks_and_an_unseen_one_allows_creep():
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


def test_a_bypass_allows_creep_once_the_chair_is_slow():
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


def test_a_clearance_in_every_tick_delays_no_evaluation_of_the_arcs():
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
