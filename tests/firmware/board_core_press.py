# The safety core, to the tick: which press moves the chair, for how long, and what is said when it
# does not.

from gazeboard.core import limits
from gazelink import codes
from gazesim.core_rig import CLOSES_MS, Core, refused

REASON = codes.FAULT_REASON
TTL_MS = limits.COMMAND_TTL_MS - limits.MARGIN_MS


def moved_ticks(core, limit=8000):
    # How many ticks it moves from now on.
    for moved in range(limit):
        core.tick()
        if not core.moving():
            return moved
    raise AssertionError("moves for ever")


def test_p3_a_command_moves_for_what_is_left_of_its_time():
    for ttl_ms in (1, 2, 3, 100, 298, 299, 300, 301, 65535):
        core = Core()
        core.arm()
        core.press(codes.FORWARD, codes.CONTINUOUS, ttl_ms, 0)
        expected = max(0, min(ttl_ms, limits.COMMAND_TTL_MS) - limits.MARGIN_MS)
        assert moved_ticks(core) == expected
        assert refused(core, codes.COMMAND_EXPIRED)
        core.command(300)
        assert refused(core, codes.COMMAND_EXPIRED)  # the same press never moves again


def test_p3_holding_on_moves_on():
    core = Core()
    core.drive()
    for _ in range(10):
        core.run(TTL_MS)
        assert core.moving()
        core.command(300)


def test_p3_a_proportional_command_lives_by_its_time_whatever_its_mode():
    for mode in (codes.STEP, codes.CONTINUOUS):
        core = Core()
        core.arm()
        core.i.linear_permille = 200
        core.press(codes.DRIVE, mode, 300, 0)
        assert moved_ticks(core) == TTL_MS
        assert refused(core, codes.COMMAND_EXPIRED)


def test_a_step_runs_to_its_end_by_itself_without_a_reason():
    for verb in (codes.FORWARD, codes.BACKWARD):
        core = Core()
        core.arm()
        core.press(verb, codes.STEP, 10, 0)
        assert moved_ticks(core) == core.settings.step_forward_ms
        assert core.safety.override == codes.NO_REASON
        assert not core.safety.permitted
        assert refused(core, codes.NO_REASON)
        core.command(300)
        assert refused(core, codes.NO_REASON)
        core.order(codes.DISARM)
        assert refused(core, codes.NO_REASON)


def test_a_step_that_reaches_its_time_limit_reports_it():
    core = Core()
    core.arm()
    core.press(codes.LEFT, codes.STEP, 10, 0)
    assert moved_ticks(core) == core.settings.step_turn_limit_ms
    assert refused(core, codes.TIME_LIMIT)


def test_a_step_needs_time_to_live_to_begin():
    core = Core()
    core.arm()
    core.press(codes.FORWARD, codes.STEP, 0, 0)
    assert refused(core, codes.COMMAND_EXPIRED)


def test_a_press_without_a_number_never_moves():
    core = Core()
    core.arm()
    core.press(codes.FORWARD)
    core.i.edge = 0
    assert refused(core, codes.NEEDS_NEW_COMMAND)


def test_a_press_keeps_its_verb_and_mode():
    held = (codes.FORWARD, codes.CONTINUOUS)
    back = (codes.BACKWARD, codes.CONTINUOUS)
    step = (codes.FORWARD, codes.STEP)
    for before, after in ((held, back), (back, held), (held, step), (step, held)):
        core = Core()
        core.drive(before[0], before[1])
        core.i.verb, core.i.mode = after
        assert refused(core, codes.BAD_COMMAND)
        core.i.verb, core.i.mode = before
        assert refused(core, codes.BAD_COMMAND)


def test_press_numbers_wrap():
    core = Core()
    core.i.edge = 254
    core.drive()
    core.press(codes.BACKWARD)
    assert core.i.edge == 1
    core.tick()
    assert core.motion.linear_permille < 0
    core.stop()
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    core.press(codes.LEFT)
    core.tick()
    assert core.moving()


def test_p12_only_a_press_ahead_of_the_newest_moves():
    # Every number after every other, the newest one running, stopped, or refused.
    core = Core()
    core.arm()
    s = core.safety
    for newest in (1, 2, 100, 127, 128, 129, 255):
        for how in ("runs", "stopped", "refused"):
            for edge in range(256):
                s.edge = 0
                s.spent_edge = (newest - 1) or 255
                core.i.owner = codes.CARETAKER if how == "refused" else codes.DRIVER
                core.i.verb = codes.FORWARD
                core.i.mode = codes.CONTINUOUS
                core.i.edge = newest
                core.command(300)
                core.tick()
                assert core.moving() == (how != "refused")
                if how == "stopped":
                    core.stop()
                core.i.owner = codes.DRIVER
                core.i.edge = edge
                core.command(300)
                core.tick()
                ahead = edge != 0 and 1 <= (edge - newest) & 0xFF <= 127
                moves = ahead or (how == "runs" and edge == newest)
                if how == "stopped" and edge:
                    # It came with the stop: which of the two was first is not known.
                    moves = moves and core.i.stop_edge != edge
                assert core.moving() == moves, (newest, how, edge)
                if not moves:  # and nothing that was refused makes an older one new
                    for old in (newest, newest - 5, newest - 100):
                        core.i.edge = (old - 1) % 255 + 1
                        core.command(300)
                        core.tick()
                        assert not core.moving(), (newest, how, edge, old)


def test_p14_a_stick_held_at_rest_ends_with_old_data():
    for old_ms in (1, 400):
        core = Core()
        core.arm()
        core.i.linear_permille = core.i.turn_permille = 0
        core.press(codes.DRIVE)
        core.run(20)
        assert core.safety.edge == core.i.edge
        core.lidar = False
        core.until(lambda: core.fault(codes.OBSTACLE_DATA_OLD), 400)
        core.run(old_ms)
        assert core.safety.override == REASON + codes.OBSTACLE_DATA_OLD
        core.lidar = True
        core.run(700)
        core.i.linear_permille = 300
        core.i.turn_permille = 300
        assert refused(core, REASON + codes.OBSTACLE_DATA_OLD)
        core.press(codes.DRIVE)
        core.tick()
        assert core.moving()


def test_p14_a_stick_that_lost_the_heading_turns_with_a_new_press_only():
    for linear in (0, 300):
        core = Core()
        core.arm()
        core.i.linear_permille = linear
        core.i.turn_permille = 0
        core.press(codes.DRIVE)
        core.run(20)
        core.i.heading_faults = 1 << codes.HEADING_JUMP
        core.run(20)
        assert core.moving() == (linear != 0)  # forward stays possible (P7)
        core.i.heading_faults = 0
        core.run(20)
        core.i.linear_permille = 300
        core.tick()
        assert core.moving()
        core.i.turn_permille = 300
        assert refused(core, codes.NEEDS_NEW_COMMAND)
        core.press(codes.DRIVE)
        core.tick()
        assert core.motion.turn_permille != 0


def test_the_silence_after_a_finished_step_is_of_its_press_only():
    core = Core()
    core.arm()
    core.press(codes.FORWARD, codes.STEP, 10, 0)
    moved_ticks(core)
    core.i.clearance_blocked = 1
    core.press(codes.FORWARD)
    assert refused(core, codes.OBSTACLE_FORWARD)
    core.i.verb = codes.STOP
    assert refused(core, codes.NO_REASON)
    core.i.verb = codes.FORWARD
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    core = Core()
    core.arm()
    core.press(codes.FORWARD, codes.STEP, 10, 0)
    moved_ticks(core)
    core.order(codes.DISARM)
    core.run(700)
    core.order(codes.ARM)
    core.run(CLOSES_MS + limits.RELAY_HOLD_MS - 1)
    core.press(codes.FORWARD)  # in the very tick in which it becomes armed
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    assert core.armed()


def test_an_unknown_verb_never_moves():
    core = Core()
    core.arm()
    core.press(6)
    assert refused(core, codes.BAD_COMMAND)


def test_stop_ends_the_press_and_has_no_reason():
    core = Core()
    core.drive()
    core.i.verb = codes.STOP
    assert refused(core, codes.NO_REASON)
    core.i.verb = codes.FORWARD
    assert refused(core, codes.NEEDS_NEW_COMMAND)


def test_p13_a_stop_after_a_finished_step_ends_its_silence_only_for_a_new_press():
    core = Core()
    core.arm()
    core.press(codes.FORWARD, codes.STEP, 10, 0)
    moved_ticks(core)
    core.stop()
    assert refused(core, codes.NO_REASON)
    core.press(codes.FORWARD)
    core.tick()
    core.stop()
    assert refused(core, codes.NEEDS_NEW_COMMAND)


def test_a_refused_press_ends_the_one_before_it():
    core = Core()
    core.drive()
    old = core.i.edge
    core.i.edge = 0  # not even a number
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    core.i.edge = old
    core.tick()
    assert not core.moving()
    core = Core()
    core.drive(codes.FORWARD, codes.STEP)
    core.press(codes.LEFT)
    core.i.clearance_blocked = 1 << codes.DIR_LEFT
    assert refused(core, codes.OBSTACLE_LEFT)
    core.i.edge -= 1
    core.i.verb = codes.FORWARD
    core.i.mode = codes.STEP
    core.hold_ms = 0
    core.command(0)
    core.tick()
    assert not core.moving()  # no step goes on where it was interrupted


def test_a_new_press_takes_over_at_once():
    core = Core()
    core.drive()
    core.press(codes.BACKWARD)
    core.tick()
    assert core.motion.linear_permille < 0
    assert core.safety.edge == core.i.edge


def test_a_press_whose_number_wrapped_keeps_its_step():
    core = Core()
    core.arm()
    core.i.edge = 254
    core.press(codes.FORWARD)
    core.tick()
    assert core.moving()
    core.press(codes.FORWARD, codes.STEP, hold_ms=0, ttl_ms=50)
    core.i.edge = 3
    core.tick()
    assert core.moving()
    core.run(200)
    assert core.moving()  # a step ends by itself
