# The safety core's arming and presses, to the tick: who may arm when, which press moves the chair,
# and what is said when it does not.

from corerig import CLOSES_MS, Core
from gazeboard import limits
from gazelink import codes

REASON = codes.FAULT_REASON
TTL_MS = limits.COMMAND_TTL_MS - limits.MARGIN_MS


def refused(core, reason):
    # The chair stands, and this is said, now and in the ticks after.
    for _ in range(3):
        core.tick()
        assert not core.moving(), core.why()
        assert core.safety.override == reason, core.why()
    return True


def moved_ticks(core, limit=8000):
    # How many ticks it moves from now on.
    for moved in range(limit):
        core.tick()
        if not core.moving():
            return moved
    raise AssertionError("moves for ever")


# -- arming ----------------------------------------------------------------------------------------


def test_arming_proves_the_relay_for_50_ms():
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.tick()
    assert core.safety.state == codes.ARMING
    assert core.safety.owner == codes.DRIVER
    assert core.safety.arm_reason == codes.NO_REASON
    assert core.toggled
    core.run(CLOSES_MS + limits.RELAY_HOLD_MS - 2)
    assert core.safety.state == codes.ARMING
    core.tick()
    assert core.armed()
    assert core.safety.owner == codes.DRIVER
    assert core.safety.arm_reason == codes.NO_REASON


def test_arming_without_feedback_waits_as_long():
    core = Core(relay_fitted=False)
    core.contact = False
    core.make_ready()
    core.order(codes.ARM)
    core.run(limits.RELAY_HOLD_MS - 1)
    assert core.safety.state == codes.ARMING
    core.tick()
    assert core.armed()
    core.order(codes.DISARM)
    core.run(700)
    core.order(codes.ARM)
    core.run(limits.RELAY_HOLD_MS - 1)
    assert core.safety.state == codes.ARMING  # counted anew


def test_a_relay_that_never_closes_ends_arming():
    core = Core()
    core.contact = False
    core.make_ready()
    core.order(codes.ARM)
    core.run(limits.RELAY_CLOSE_MS - 1)
    assert core.safety.state == codes.ARMING
    core.tick()
    assert core.safety.state == codes.ARMING  # judged before this tick is counted
    core.tick()
    assert core.safety.state == codes.DISARMED
    assert core.only_fault(codes.RELAY_OPEN)
    assert not core.toggled


def test_a_relay_that_chatters_never_arms():
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.tick()
    for _ in range(40):
        core.contact = True
        core.run(limits.RELAY_HOLD_MS - 1)
        core.contact = False
        core.tick()
        assert not core.armed()
    assert core.fault(codes.RELAY_OPEN)


def test_a_relay_that_closes_late_still_counts():
    core = Core()
    core.contact = False
    core.make_ready()
    core.order(codes.ARM)
    core.run(limits.RELAY_CLOSE_MS)
    core.contact = True
    core.run(limits.RELAY_HOLD_MS)
    assert core.armed()


def test_neutral_must_be_proven_for_half_a_second():
    core = Core()
    core.run(limits.NEUTRAL_PROVEN_MS)
    assert core.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    core.tick()
    assert core.safety.arm_reason == codes.NO_REASON
    core.verified = False
    core.tick()
    core.verified = True
    core.run(limits.NEUTRAL_PROVEN_MS)
    assert core.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    core.tick()
    assert core.safety.arm_reason == codes.NO_REASON
    core.safety.wipers_written(True, False)
    core.run(limits.NEUTRAL_PROVEN_MS - 1)
    core.order(codes.ARM)
    core.tick()
    assert core.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    core.run(5)
    assert core.safety.state == codes.DISARMED  # asked too early: not kept


def test_nothing_may_be_commanded_for_300_ms():
    core = Core()
    core.make_ready()
    core.press(codes.FORWARD, hold_ms=0, ttl_ms=100)
    core.tick()
    assert core.safety.arm_reason == codes.COMMAND_ACTIVE
    assert core.safety.override == codes.NOT_ARMED
    core.run(97)
    assert core.safety.ttl_ms == 0 + 100 - limits.MARGIN_MS - 97
    core.run(limits.IDLE_MS - 1)
    assert core.safety.arm_reason == codes.COMMAND_ACTIVE
    core.tick()
    assert core.safety.arm_reason == codes.NO_REASON  # repeated without time to live: no command
    core.i.verb = codes.STOP
    core.command(300)
    core.tick()
    assert core.safety.arm_reason == codes.NO_REASON  # a stop is no command


def test_arming_needs_a_session():
    core = Core()
    core.i.session_count = 0
    core.run(700)
    assert core.safety.arm_reason == codes.NOT_CONNECTED
    core.order(codes.ARM)
    core.run(3)
    assert core.safety.state == codes.DISARMED


def test_arming_needs_an_open_contact():
    core = Core()
    core.make_ready()
    core.contact = True
    core.tick()
    assert core.safety.arm_reason == REASON + codes.RELAY_STUCK
    core.order(codes.ARM)
    core.tick()
    assert core.safety.state == codes.DISARMED


def test_arming_needs_a_driver_or_a_caretaker():
    for owner, arms in ((0, False), (1, True), (2, True), (3, False), (255, False)):
        core = Core()
        core.make_ready()
        core.order(codes.ARM, owner)
        core.tick()
        assert (core.safety.state == codes.ARMING) == arms
        assert core.safety.owner == (owner if arms else codes.NOBODY)


def test_any_fault_refuses_arming_and_ends_it():
    for bit in (codes.HEADING_JUMP, codes.HEADING_FROZEN):
        core = Core()
        core.make_ready()
        core.i.heading_faults = 1 << bit
        core.order(codes.ARM)
        core.tick()
        assert core.safety.state == codes.DISARMED
        assert core.safety.arm_reason == REASON + bit
        core.i.heading_faults = 0
        core.order(codes.ARM)
        core.tick()
        assert core.safety.state == codes.ARMING
        core.i.heading_faults = 1 << bit
        core.tick()
        assert core.safety.state == codes.DISARMED
        assert not core.toggled
        assert core.safety.arm_reason == REASON + bit


def test_arming_begins_a_new_explanation():
    core = Core()
    core.i.tilted = True
    core.run(600)
    core.i.tilted = False
    core.tick()
    assert core.safety.first_fault != codes.NO_REASON
    core.arm()
    assert core.safety.first_fault == codes.NO_REASON


def test_a_second_person_cannot_take_over_while_arming():
    core = Core()
    core.make_ready()
    core.order(codes.ARM, codes.DRIVER)
    core.tick()
    core.order(codes.ARM, codes.CARETAKER)
    core.until(core.armed, 200)
    assert core.safety.owner == codes.DRIVER


def test_an_order_is_obeyed_once():
    core = Core()
    core.arm()
    core.order(codes.DISARM)
    core.tick()
    assert core.safety.state == codes.DISARMED
    core.i.order_action = codes.ARM
    core.run(1000)
    assert core.safety.state == codes.DISARMED  # the number is old
    core.i.order_number = 7
    core.new_session()
    core.run(1000)
    core.i.order_number = 7  # another session counts anew
    core.tick()
    assert core.safety.state == codes.ARMING


def test_an_order_in_the_tick_of_its_session_counts():
    core = Core()
    core.arm()
    core.run(600)
    core.order(codes.DISARM)
    core.run(700)
    number = core.i.order_number
    core.new_session()
    core.i.order_action = codes.ARM
    core.i.order_number = number
    core.tick()
    assert core.safety.state == codes.ARMING


def test_disarm_ends_everything():
    core = Core()
    core.drive()
    core.order(codes.DISARM, codes.NOBODY)
    core.tick()
    assert core.safety.state == codes.DISARMED
    assert core.safety.owner == codes.NOBODY
    assert not core.toggled
    assert refused(core, codes.NOT_ARMED)


def test_hand_over_stops_and_waits_for_the_new_owners_press():
    core = Core()
    core.drive()
    core.order(codes.ARM, codes.CARETAKER)
    assert refused(core, codes.NOT_OWNER)
    assert core.armed()
    assert core.safety.owner == codes.CARETAKER
    core.i.owner = codes.CARETAKER
    assert refused(core, codes.NOT_OWNER)  # the driver's press stays the driver's
    core.press(codes.FORWARD)
    core.i.owner = codes.CARETAKER
    core.tick()
    assert core.moving()


def test_arming_again_changes_nothing():
    core = Core()
    core.drive()
    for owner in (codes.DRIVER, codes.NOBODY, 3):
        core.order(codes.ARM, owner)
        core.tick()
        assert core.moving()
        assert core.safety.owner == codes.DRIVER


# -- which press moves -----------------------------------------------------------------------------


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


def test_a_step_runs_to_its_end_by_itself_and_says_nothing():
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


def test_a_step_that_reaches_its_time_limit_says_so():
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
    for verb, mode in ((codes.BACKWARD, codes.CONTINUOUS), (codes.FORWARD, codes.STEP)):
        core = Core()
        core.drive(codes.FORWARD, codes.CONTINUOUS)
        core.i.verb = verb
        core.i.mode = mode
        assert refused(core, codes.BAD_COMMAND)
        core.i.verb = codes.FORWARD
        core.i.mode = codes.CONTINUOUS
        assert refused(core, codes.BAD_COMMAND)


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


def test_p13_anyones_stop_ends_the_press_with_a_reason_for_who_still_holds_it():
    for mode in (codes.STEP, codes.CONTINUOUS):
        core = Core()
        core.drive(codes.FORWARD, mode)
        core.stop()
        assert refused(core, codes.NEEDS_NEW_COMMAND)
        core.press(codes.FORWARD)
        core.tick()
        assert core.moving()  # the stop is not remembered


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


def test_p13_only_the_owner_moves():
    for owner in (0, 2, 3):
        core = Core()
        core.drive()
        core.i.owner = owner
        assert refused(core, codes.NOT_OWNER)
        core.i.owner = codes.DRIVER
        assert refused(core, codes.NOT_OWNER)


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


def test_a_press_held_while_arming_needs_to_be_made_anew():
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.tick()
    core.press(codes.FORWARD)
    core.tick()
    assert core.safety.override == codes.NOT_ARMED
    core.until(core.armed, 200)
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.run(CLOSES_MS + limits.RELAY_HOLD_MS - 1)
    core.press(codes.FORWARD)  # in the very tick in which it becomes armed
    assert refused(core, codes.NEEDS_NEW_COMMAND)
    assert core.armed()


def test_p14_after_a_new_session_no_press_of_the_old_life_goes_on():
    core = Core()
    core.drive(codes.FORWARD, codes.STEP)
    old = core.i.edge
    core.new_session()
    core.i.edge = old  # the new host repeats the old press in the same millisecond
    core.i.verb = codes.FORWARD
    core.hold_ms = 0
    core.command(0)
    core.tick()
    assert core.safety.state == codes.DISARMED
    assert core.safety.edge == 0
    assert refused(core, codes.NOT_ARMED)
    core.make_ready()
    core.order(codes.ARM)
    core.run(CLOSES_MS + limits.RELAY_HOLD_MS - 1)
    core.i.edge = old + 1
    core.tick()
    assert core.armed()
    core.i.edge = old  # no time to live, no step under way: nothing may move
    core.tick()
    assert not core.moving(), core.why()


def test_not_armed_is_the_reason_before_all_others():
    core = Core()
    core.i.clearance_blocked = 15
    core.make_ready()
    core.press(codes.FORWARD)
    assert refused(core, codes.NOT_ARMED)


# -- P5: directions --------------------------------------------------------------------------------


def test_p5_a_blocked_direction_refuses_what_goes_there_and_nothing_else():
    for verb, linear, turn, needs in (
        (codes.FORWARD, 0, 0, 1),
        (codes.BACKWARD, 0, 0, 2),
        (codes.LEFT, 0, 0, 4),
        (codes.RIGHT, 0, 0, 8),
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
