# Driving and turning at once at the edges of the rule: ages, rows, bands and waits.

from board_core_arcs_rule import Drive, Way, from_there
from gazeboard.core import limits
from gazelink import arcs, codes

WAIT = limits.CLEAR_MS // 8 + 1  # judgements
CREEP = 30


# A drive ahead to the left whose directions are all alike, but in what a turn's stop adds.
def plain(linear=1000, turn=1000, full=2000, margin=0, turn_full=400, turn_margin=0):
    drive = Drive(1)
    settings = drive.rule.settings
    settings.linear_permille = settings.turn_permille = settings.step_turn_permille = 1000
    settings.hold_permille = 100
    for at in range(8):
        chair = drive.rule.chairs[at]
        chair.ms = 300
        chair.permille = [CREEP, 999]
        chair.full, chair.margin = (turn_full, turn_margin) if at & 2 else (full, margin)
    drive.arcs.configure(settings, drive.rule.chairs)
    drive.i.verb = codes.DRIVE
    drive.i.linear_permille = linear
    drive.i.turn_permille = turn
    drive.i.cap_permille = 1000
    drive.arcs.changed(drive.i)
    return drive


def see(drive, units):
    drive.i.clearance_arcs[:] = bytes([units]) * arcs.SIZE


def judged(drive):
    drive.arcs.judge(drive.i, 0, drive.age_ms, 0)
    return drive.says()


FULL = (False, 1000, 1000)


# Judgements until more is allowed.
def waits(drive):
    before = drive.says()
    count = 1
    while judged(drive) == before:
        count += 1
    return count


def test_a_new_command_is_as_fast_as_its_way_just_allows():
    # At 2 m/s it stops within 600 mm and slows down 1000 mm before.
    for margin, units in ((0, 160), (1, 161)):
        drive = plain(margin=margin)
        see(drive, units)
        assert judged(drive) == FULL
        drive = plain(margin=margin)
        see(drive, units - 1)
        assert judged(drive)[1] < 1000


def test_more_is_allowed_with_60_mm_to_spare():
    for margin, units in ((0, 166), (1, 167)):
        drive = plain(margin=margin)
        see(drive, 10)
        judged(drive)
        see(drive, units)
        assert waits(drive) == WAIT
        assert drive.says() == FULL
        see(drive, 10)
        judged(drive)
        see(drive, units - 1)
        assert waits(drive) == WAIT
        assert 0 < drive.says()[1] < 1000


# Only these rows have a way, of the quadrant that is driven into, and of no other.
def only(drive, *rows):
    see(drive, 0)
    for row in rows:
        drive.i.clearance_arcs[row] = arcs.FAR


def test_a_turn_ends_in_the_first_row_that_holds_it():
    # At 25 degrees/s it stops within 112 and slows down 200 sixteenths before.
    for margin, row in ((72, 4), (73, 5)):
        drive = plain(turn_margin=margin)
        only(drive, 0, row)
        assert judged(drive) == FULL, margin
        drive = plain(turn_margin=margin)
        only(drive, 0, row - 1, row + 1)
        assert judged(drive) != FULL, margin
    # None holds it: what the next quadrant's first one says is no matter.
    drive = plain(turn_margin=1000)
    see(drive, arcs.FAR)
    assert judged(drive) != FULL


def test_more_of_a_turn_is_allowed_with_three_degrees_to_spare():
    for margin, row in ((24, 4), (25, 5)):
        drive = plain(turn_margin=margin)
        only(drive)
        assert judged(drive)[0]
        only(drive, *range(row + 1))
        assert waits(drive) == WAIT
        assert drive.says() == FULL, margin
        only(drive)
        judged(drive)
        only(drive, *range(row))
        assert waits(drive) == WAIT
        assert drive.says() != FULL, margin
    drive = plain(turn_margin=880)
    only(drive)
    judged(drive)
    see(drive, arcs.FAR)
    assert waits(drive) == WAIT
    assert drive.says() != FULL


def test_a_view_that_got_worse_makes_the_wait_begin_anew():
    for worse in ("blocks between", "is judged", "slows down"):
        drive = plain()
        see(drive, 50)
        assert not judged(drive)[0]
        see(drive, arcs.FAR)
        for _ in range(WAIT - 1):
            assert judged(drive)[1] < 1000
        see(drive, 20 if worse == "slows down" else 0)
        if worse == "blocks between":
            assert drive.arcs.too_near(drive.i, 0) == 1
            drive.arcs.block()
        else:
            judged(drive)
        see(drive, arcs.FAR)
        assert waits(drive) == WAIT, worse
        assert drive.says() == FULL


def test_each_step_up_takes_its_wait():
    drive = plain()
    see(drive, 50)
    judged(drive)
    for units in (90, 120, arcs.FAR):
        see(drive, units)
        assert waits(drive) == WAIT
    assert drive.says() == FULL


# Which quadrant is the one into which it rolls, or turns, on.
def test_what_rolls_on_counts_on_its_own_side():
    for linear, turn, rolls in (
        (0, 1000, codes.DIR_FORWARD),
        (0, -1000, codes.DIR_FORWARD),
        (0, 1000, codes.DIR_BACKWARD),
        (1000, 0, codes.DIR_LEFT),
        (-1000, 0, codes.DIR_LEFT),
        (1000, 0, codes.DIR_RIGHT),
    ):
        backward = linear < 0 or rolls == codes.DIR_BACKWARD
        right = turn < 0 or rolls == codes.DIR_RIGHT
        first = arcs.ROWS * (int(backward) + 2 * int(right))
        for near in range(0, 4 * arcs.ROWS, arcs.ROWS):
            drive = plain(linear, turn)
            way = drive.ways[rolls]
            way.rolls = way.speed = way.stop = 100
            drive.arcs.feel(rolls, way)
            see(drive, arcs.FAR)
            for row in range(near, near + arcs.ROWS):
                drive.i.clearance_arcs[row] = 0
            assert judged(drive)[0] == (near == first), (linear, turn, rolls, near)


def test_what_moved_since_counts_though_it_would_stop_at_once():
    # 10 mm, and 5 degrees.
    for at, speed, age_ms in ((codes.DIR_FORWARD, 96, 96), (codes.DIR_LEFT, 1232, 64)):
        drive = plain()
        judged(drive)
        drive.ways[at].speed = speed
        drive.arcs.feel(at, drive.ways[at])
        only(drive, 0)
        drive.i.clearance_arcs[0] = 1
        assert drive.arcs.too_near(drive.i, age_ms) == 0


def test_the_faster_of_two_sides_counts():
    for fast in (codes.DIR_LEFT, codes.DIR_RIGHT):
        drive = plain(1000, -1000)
        for at in (codes.DIR_LEFT, codes.DIR_RIGHT):
            drive.ways[at].speed = 1000 if at == fast else 100
            drive.arcs.feel(at, drive.ways[at])
        judged(drive)
        see(drive, 0)
        drive.i.clearance_arcs[arcs.BOTH_AT] = arcs.FAR  # 12 degrees
        assert drive.arcs.too_near(drive.i, 0) == 0
        assert drive.arcs.too_near(drive.i, 300) == 1


def test_nothing_is_limited_before_it_is_judged():
    for verb in range(6):
        drive = Drive(1)
        assert drive.says() == (False, 1000, 1000)
        drive.i.verb = verb
        assert drive.arcs.changed(drive.i) == int(verb != codes.STOP)
        assert drive.arcs.too_near(drive.i, 0) == 0


# A chair that drives ahead to the left, and the first row that holds a turn.
def test_an_old_clearance_counts_from_where_it_was_measured():
    drive = Drive(1)
    i = drive.i
    i.verb = codes.DRIVE
    i.linear_permille = i.turn_permille = 500
    drive.arcs.changed(i)
    drive.arcs.judge(i, 0, 0, 0)
    ahead, aside = drive.ways[codes.DIR_FORWARD], drive.ways[codes.DIR_LEFT]
    for speed, age_ms in ((0, 60000), (0, 0), (20, 300), (18, 60000), (819, 40), (817, 40)) + (
        (700, 137),
        (790, 100),  # a row's turn exactly, with nothing for stopping
        (819, 1000),
        (1200, 41),
        (1200, 109),
    ):
        moved = from_there([Way()], [0], 0) + speed * age_ms // 1000
        assert speed * age_ms < 1000 * moved <= speed * age_ms + 1000
        for over in (0, 1):
            # Ahead: its stop ends at a unit, or beyond it.
            units = moved // arcs.UNIT_MM + 1
            ahead.speed, ahead.stop = speed, units * arcs.UNIT_MM - moved + over
            aside.speed = aside.stop = 0
            for at in range(4):
                drive.arcs.feel(at, drive.ways[at])
            i.clearance_arcs[:] = bytes([units]) * arcs.SIZE
            assert drive.arcs.too_near(i, age_ms) == over, (speed, age_ms)
            # Aside: at the turn of a row, or beyond it; of the last one, too.
            ahead.speed = ahead.stop = 0
            for row in range(arcs.ROWS):
                aside.speed, aside.stop = speed, 16 * arcs.TURNS_DEG[row] - moved + over
                if aside.stop < 0:
                    continue
                for at in range(4):
                    drive.arcs.feel(at, drive.ways[at])
                i.clearance_arcs[:] = arcs.ALL_FAR
                for beyond in range(row + 1, arcs.ROWS):
                    i.clearance_arcs[beyond] = 0
                assert drive.arcs.too_near(i, age_ms) == over, (speed, age_ms, row)


def moving(drive, *directions):
    for at in directions:
        way = drive.ways[at]
        way.speed = 60
        way.rolls = 200
        drive.arcs.feel(at, way)


def test_more_is_allowed_once_both_sides_have_to_spare():
    for side in range(arcs.SIDES):
        drive = plain()
        moving(drive, codes.DIR_BACKWARD)
        only(drive)
        assert judged(drive)[0]
        see(drive, arcs.FAR)
        drive.i.clearance_arcs[arcs.BOTH_AT + arcs.BOTH_ROWS * side + 1] = 165
        assert waits(drive) == WAIT
        assert drive.says()[1] < 1000
        drive.i.clearance_arcs[arcs.BOTH_AT + arcs.BOTH_ROWS * side + 1] = 166
        assert waits(drive) == WAIT
        assert drive.says() == FULL


def test_a_turn_that_is_reversed_stops_as_the_new_one_does():
    for verb in (codes.LEFT, codes.RIGHT):
        for slow in (codes.DIR_LEFT, codes.DIR_RIGHT):
            drive = plain()
            drive.rule.chairs[slow].margin = 600
            drive.arcs.configure(drive.rule.settings, drive.rule.chairs)
            drive.i.verb = verb
            drive.arcs.changed(drive.i)
            moving(drive, codes.DIR_FORWARD, codes.DIR_LEFT, codes.DIR_RIGHT)
            see(drive, arcs.FAR)
            drive.i.clearance_arcs[arcs.BOTH_AT + 2] = 0  # more than 28 degrees
            assert (judged(drive)[2] == 1000) == (slow != verb - 1)
