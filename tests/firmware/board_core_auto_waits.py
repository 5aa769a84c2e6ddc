# An auto motion in the core waits for an obstacle to pass, for a while (P20).

from autorig import going, spent
from gazeboard.core import limits
from gazelink import codes
from gazesim.core_rig import Core


def block(core):
    core.i.clearance_blocked = 15


def test_what_an_obstacle_overrules_waits_and_goes_on_by_itself():
    core = going()
    block(core)
    core.tick()
    for _ in range(5000):
        core.tick()
        assert not core.moving()
        assert core.safety.override == codes.OBSTACLE_FORWARD
        assert core.safety.edge == core.i.edge
    core.free()
    core.until(core.moving, 800)
    # And the next wait is as long again.
    block(core)
    core.run(9000)
    assert core.safety.edge == core.i.edge
    core.free()
    core.until(core.moving, 800)


def test_overruled_for_10_s_it_ends():
    for linear, turn, reason in (
        (500, 0, codes.OBSTACLE_FORWARD),
        (-500, 0, codes.OBSTACLE_BACKWARD),
        (0, 400, codes.OBSTACLE_LEFT),
        (0, -400, codes.OBSTACLE_RIGHT),
    ):
        core = going(linear, turn)
        block(core)
        core.tick()
        ms = 0
        while core.safety.override == reason:
            assert not core.moving()
            core.tick()
            ms += 1
        assert ms == limits.AUTO_OVERRULED_MS, (ms, core.why())
        core.free()
        core.i.linear_permille, core.i.turn_permille = 0, 0
        core.see()
        core.i.linear_permille = 500
        assert spent(core, codes.AUTO_OVERRULED)


# How many ticks an obstacle overrules it until it ends.
def overruled_ms(core):
    block(core)
    core.tick()
    ms = 0
    while core.safety.edge:
        core.tick()
        ms += 1
    assert core.safety.override == codes.AUTO_OVERRULED
    return ms


def test_each_wait_is_counted_from_nothing():
    for before_ms in (0, 5000):
        core = going()
        if before_ms:
            block(core)
            core.run(before_ms)
            core.i.linear_permille = 0
            core.free()
            core.see()
            assert core.safety.auto.overruled_ms > before_ms // 2
        core.auto(0, 0)  # begins by standing
        core.tick()
        core.i.linear_permille = 500
        assert overruled_ms(core) == limits.AUTO_OVERRULED_MS
    core = going()
    block(core)
    core.run(5000)
    core.free()
    core.until(core.moving, 800)
    assert overruled_ms(core) == limits.AUTO_OVERRULED_MS


def test_a_press_that_begins_where_it_is_blocked_does_not_wait():
    for before in (0, 5, 255):
        core = Core()
        core.arm()
        if before:
            core.i.edge = before - 1
            core.auto()
            core.tick()
            assert core.moving(), core.why()
            assert core.safety.edge == before
        block(core)
        core.tick()
        core.auto()
        core.tick()
        assert core.safety.edge == 0
        assert core.safety.spent_edge == core.i.edge
        core.free()
        core.see()
        for _ in range(800):
            core.tick()
            assert not core.moving()


def test_standing_by_itself_is_not_having_moved():
    core = going()
    block(core)
    core.run(9000)
    core.i.linear_permille = 0  # permitted, as nothing is asked
    core.run(500)
    assert core.safety.edge == core.i.edge
    core.i.linear_permille = 500
    core.run(999)
    assert core.safety.edge == core.i.edge, core.why()
    core.run(3)
    assert core.safety.override == codes.AUTO_OVERRULED
    # Having moved in another direction is.
    core = going()
    core.i.clearance_blocked = 1 << codes.DIR_FORWARD
    core.run(9500)
    core.i.linear_permille = 0
    for turn in (300, -300):
        core.i.turn_permille = turn
        core.tick()
        assert core.moving()
    core.i.linear_permille, core.i.turn_permille = 500, 0
    core.run(9500)
    assert core.safety.edge == core.i.edge
    assert core.safety.override == codes.OBSTACLE_FORWARD


def test_each_press_may_wait_anew():
    core = going()
    block(core)
    core.run(9900)
    core.free()
    core.i.linear_permille = 0
    core.see()
    core.auto()
    core.tick()
    assert core.safety.auto.overruled_ms == 0
    block(core)
    core.run(5000)
    assert core.safety.edge == core.i.edge


def test_missed_ticks_count_while_it_waits():
    core = going()
    block(core)
    core.run(3)
    waited_ms = core.safety.auto.overruled_ms
    core.safety.missed_ms = 20
    core.tick()
    assert core.safety.auto.overruled_ms == waited_ms + 21


def test_it_waits_for_obstacles_only():
    auto = Core().safety.auto
    for reason in range(len(codes.REASONS)):
        passes = reason == codes.ABOVE_CREEP or (
            codes.OBSTACLE_FORWARD <= reason <= codes.OBSTACLE_RIGHT
        )
        assert auto.waits(reason, 0) is passes, reason
    for fault in range(len(codes.FAULTS)):
        assert auto.waits(codes.FAULT_REASON + fault, 0) is False
    # Old data is no obstacle that passes: it ends the press, also while it waits.
    core = going()
    block(core)
    core.run(100)
    core.lidar = False
    core.until(lambda: core.safety.edge == 0, 400)
    assert core.safety.override == codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
    # And so do a lost heading in a turn, silence of the planner and of who watches.
    core = going(0, 400)
    core.i.heading_faults = 1 << codes.HEADING_JUMP
    core.tick()
    core.i.heading_faults = 0
    assert spent(core, codes.FAULT_REASON + codes.HEADING_JUMP)
    for silent, reason in ((1, codes.COMMAND_EXPIRED), (2, codes.SUPERVISION_LOST)):
        core = going()
        block(core)
        core.run(10)
        if silent == 1:
            core.hold_ms = 0
        else:
            core.watched = False
        core.until(lambda core=core: core.safety.edge == 0, 3000)
        assert core.safety.override == reason


def test_a_held_drive_never_waits():
    core = Core()
    core.arm()
    core.i.linear_permille = 500
    core.press(codes.DRIVE)
    core.tick()
    assert core.moving()
    block(core)
    core.tick()
    assert not core.moving()
    assert core.safety.edge == 0


# Another place, chosen while the board overrules the curve to the one before.
def test_another_press_that_begins_by_standing_is_not_lost_to_the_curve_of_the_one_before():
    core = going(500, 200)
    core.run(1500)
    core.i.clearance_arc_views = 0
    core.i.clearance_arcs = bytearray(len(core.i.clearance_arcs))
    core.run(60)
    assert core.safety.override == codes.OBSTACLE_LEFT
    core.auto(0, 0)
    for _ in range(20):
        core.tick()
        assert core.safety.edge == core.i.edge
        assert core.safety.override == codes.NO_REASON
        assert core.motion.linear_permille == core.motion.turn_permille == 0
    core.i.linear_permille, core.i.turn_permille = 500, 200
    core.tick()
    assert core.safety.override == codes.OBSTACLE_LEFT
    assert not core.moving()
