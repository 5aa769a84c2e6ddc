# The safety core, to the tick: who may arm when, and what is said when not.

from gazeboard.core import ages, limits
from gazelink import codes
from gazesim.core_rig import CLOSES_MS, Core, refused

REASON = codes.FAULT_REASON


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
    core.tick()
    assert core.safety.arm_reason == codes.NO_REASON
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
    assert core.safety.ages.words[ages.TTL] == 0 + 100 - limits.MARGIN_MS - 97
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


def test_a_take_over_while_arming_is_not_lost():
    for first, then in ((codes.DRIVER, codes.CARETAKER), (codes.CARETAKER, codes.DRIVER)):
        core = Core()
        core.see()
        core.make_ready()
        core.order(codes.ARM, first)
        core.tick()
        core.order(codes.ARM, then)
        core.until(core.armed, 200)
        assert core.safety.owner == then
        core.press(codes.FORWARD)
        core.i.owner = then
        core.tick()
        assert core.moving()


def test_an_order_is_obeyed_once():
    core = Core()
    core.arm()
    core.tick()
    assert core.armed()
    core.order(codes.DISARM)
    core.tick()
    assert core.safety.state == codes.DISARMED
    core.run(1000)
    assert core.safety.state == codes.DISARMED
    core.order(codes.ARM)
    core.run(200)
    assert core.armed()


def test_an_order_to_arm_or_to_reset_dies_with_its_session():
    core = Core()
    core.make_ready()
    core.order(codes.ARM)
    core.new_session()
    core.run(1000)
    assert core.safety.state == codes.DISARMED
    core.order(codes.ARM)
    core.tick()
    assert core.safety.state == codes.ARMING
    core.emergency_message()
    core.tick()
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.new_session()
    core.run(1000)
    assert core.only_fault(codes.EMERGENCY)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.tick()
    assert core.safety.faults == 0


def test_nobody_arms_in_the_tick_of_a_reset():
    for by_order in (True, False):
        core = Core()
        core.make_ready()
        if by_order:
            core.order(codes.RESET_FAULTS, codes.CARETAKER)
        else:
            core.button = True
            core.run(limits.RESET_PRESS_MS - 1)
        core.order(codes.ARM)
        core.tick()
        assert core.safety.state == codes.DISARMED
        core.order(codes.ARM)
        core.tick()
        assert core.safety.state == codes.ARMING


def test_two_people_who_ask_at_once_stop_the_chair_and_the_last_one_drives():
    for first, last in ((1, 2), (2, 1), (1, 1)):
        core = Core()
        core.drive()
        core.order(codes.ARM, first)
        core.order(codes.ARM, last)
        assert refused(core, codes.NOT_OWNER)
        assert core.safety.owner == last


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


def test_hand_over_ends_the_press_whoever_repeats_it():
    for old, new in ((codes.DRIVER, codes.CARETAKER), (codes.CARETAKER, codes.DRIVER)):
        core = Core()
        core.arm(old)
        core.press(codes.FORWARD)
        core.i.owner = old
        core.tick()
        assert core.moving()
        core.order(codes.ARM, new)
        core.i.owner = new
        assert refused(core, codes.NOT_OWNER)
        assert core.safety.owner == new


def test_only_the_order_to_arm_arms():
    for action in (codes.DISARM, codes.EMERGENCY_STOP, codes.RESET_FAULTS):
        core = Core()
        core.make_ready()
        core.order(action)
        core.tick()
        assert core.safety.state == codes.DISARMED


def test_arming_again_changes_nothing():
    core = Core()
    core.drive()
    for owner in (codes.DRIVER, codes.NOBODY, 3):
        core.order(codes.ARM, owner)
        core.tick()
        assert core.moving()
        assert core.safety.owner == codes.DRIVER


def test_a_relay_that_is_fitted_later_counts_from_then_on():
    core = Core(relay_fitted=False)
    core.contact = False
    core.arm()
    core.order(codes.DISARM)
    core.run(5)
    core.safety.set_relay_fitted(True)
    core.make_ready()
    core.order(codes.ARM)
    core.run(300)
    assert not core.armed()
    assert core.fault(codes.RELAY_OPEN)
    core.safety.set_relay_fitted(False)
    core.arm()
