"""What assist asks for is what the board's own rule permits, with some room."""

import random

import pytest

from gazeboard.core.obstacles import ARC_BLOCKED, Obstacles
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazechair.assist.permits import Permits
from gazechair.board.board_commands import Clearance
from gazelink import arcs, codes
from gazemeasure.obstacles_run import deliver
from gazesim.zone import zone_of


def permits(clearance):
    found = Permits()
    found.zone = zone_of()
    found.clearance = clearance
    return found


def test_nothing_is_permitted_before_the_board_and_a_lidar_have_said_anything():
    nothing = Permits()
    assert not nothing.seen
    assert not nothing.both(300, 100)
    assert not nothing.on_the_spot(100)


def test_all_is_permitted_where_nothing_is_near():
    far = permits(Clearance(0, codes.REAL, 1.0))
    assert far.seen
    assert far.both(1000, 300)
    assert far.on_the_spot(-400)


@pytest.mark.parametrize("blind", [{"blocked": 1}, {"blocked": 4}, {"arc_views": 1}])
def test_where_a_lidar_is_blind_nothing_is_known(blind):
    fields = {"blocked": 0, "source": codes.REAL, "acquired_s": 1.0} | blind
    assert not permits(Clearance(**fields)).seen


def test_what_it_permits_the_board_does_not_block():
    chance = random.Random(16)
    tried = 0
    while tried < 60:
        turn_q4 = chance.randint(0, 800)
        rows = sorted((chance.randint(0, 255) for _ in range(arcs.ROWS)), reverse=True)
        clearance = Clearance(
            0,
            codes.REAL,
            0.0,
            forward_mm=6000,
            left_q4_deg=turn_q4,
            right_q4_deg=turn_q4,
            arcs=bytes(rows) * arcs.QUADRANTS + bytes(sorted(rows[:6], reverse=True)),
        )
        linear, turn = chance.choice((250, 500, 600)), chance.choice((-300, -100, 100, 250))
        asked = permits(clearance)
        if not asked.both(linear, turn):
            continue
        tried += 1
        board, inputs = Obstacles(Settings()), Inputs()
        inputs.cap_permille = 1000
        inputs.verb, inputs.mode = codes.DRIVE, codes.CONTINUOUS
        inputs.linear_permille, inputs.turn_permille = linear, turn
        out = (0, 0)
        for ms in range(600):
            if ms % 50 == 0:
                deliver(inputs, clearance, 0.02)
            board.step(inputs, *out, True, False)
            if ms > 400:  # it has looked for long enough to believe the view
                out = (linear, turn)
                assert not board.blocked & ARC_BLOCKED


def near(at, count, cm):
    """Clearance with room everywhere but for these rows of the arcs."""
    ways = bytearray(arcs.ALL_FAR)
    ways[at : at + count] = bytes([cm]) * count
    return Clearance(0, codes.REAL, 1.0, arcs=bytes(ways))


@pytest.mark.parametrize("side", [1, -1])
def test_the_side_that_is_asked_for_counts_however_little_it_turns(side):
    beside = permits(near(0 if side > 0 else 2 * arcs.ROWS, arcs.ROWS, 2))
    beside.output(0.9, 600, -side * 130)  # it has just turned more to the other one
    assert not beside.both(0, side * 30)
    assert beside.both(300, -side * 100)


@pytest.mark.parametrize("side", [1, -1])
def test_an_older_turn_to_the_other_side_counts_until_it_has_faded(side):
    asked = permits(near(arcs.BOTH_AT, arcs.SIZE - arcs.BOTH_AT, 2))
    asked.output(0.0, 0, -side * 500)
    asked.output(0.9, 0, 0)
    assert not asked.both(250, side * 250)
    asked.output(1.8, 0, 0)
    assert asked.both(250, side * 250)


def test_a_turn_begins_where_the_board_lets_it_creep_and_a_little_more():
    for deg, may in ((12, False), (15, False), (17, True)):
        one = permits(Clearance(0, codes.REAL, 1.0, left_q4_deg=16 * deg, right_q4_deg=0))
        assert one.may_turn(1) is may
        assert not one.may_turn(-1)


def test_it_remembers_when_too_little_was_free_ahead_to_go_on():
    one = permits(None)
    for at_s, forward_mm, shut_s in ((1, 200, 1), (2, 240, 1), (3, 0, 3), (4, 900, 3)):
        one.clearance = Clearance(0, codes.REAL, float(at_s), forward_mm=forward_mm)
        assert one.shut_s == shut_s
