# The safety core, to the tick: faults of the board itself, the relay and the emergency stop.

from gazeboard.core import limits
from gazelink import codes
from gazesim.core_rig import Core

REASON = codes.FAULT_REASON


# -- P8: wipers ------------------------------------------------------------------------------------


def test_p8_three_failures_in_a_row_trip_and_two_do_not():
    core = Core()
    core.drive()
    for _ in range(5):
        core.verified = False
        core.run(limits.WIPER_TRIES - 1)
        assert core.toggled is False
        assert core.moving()
        core.verified = True
        core.tick()
        assert core.toggled
    core.verified = False
    core.run(limits.WIPER_TRIES)
    assert core.only_fault(codes.WIPER)
    assert core.safety.state == codes.DISARMED
    assert not core.safety.enable
    assert not core.safety.permitted
    assert core.safety.override == REASON + codes.WIPER
    assert core.safety.arm_reason == REASON + codes.WIPER
    assert core.safety.first_fault == REASON + codes.WIPER
    core.verified = True
    core.run(2000)
    assert core.only_fault(codes.WIPER)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.tick()
    assert core.safety.faults == 0


def test_p8_a_reset_while_writes_still_fail_trips_again_in_the_same_tick():
    core = Core()
    core.verified = False
    core.run(70000)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.tick()
    assert core.only_fault(codes.WIPER)
    assert core.safety._wiper_bad == limits.WIPER_TRIES  # counts no further


def test_p8_three_tries_from_the_first_tick():
    core = Core()
    core.verified = False
    core.run(limits.WIPER_TRIES - 1)
    assert core.safety.faults == 0
    core.tick()
    assert core.only_fault(codes.WIPER)


def test_what_disarms_is_the_reason_not_what_only_warned():
    core = Core()
    core.drive()
    core.i.heading_faults = 1 << codes.HEADING_JUMP
    core.late = True
    core.tick()
    assert core.safety.override == REASON + codes.TICK_STALLED


def test_p8_resets_never_lengthen_the_three_tries():
    core = Core()
    core.drive()
    core.verified = False
    for _ in range(limits.WIPER_TRIES):
        core.order(codes.RESET_FAULTS, codes.CARETAKER)
        core.tick()
    assert core.only_fault(codes.WIPER)


# -- P10: the tick ---------------------------------------------------------------------------------


def test_p10_a_late_tick_disarms_and_clears_after_half_a_second_without_another():
    core = Core()
    core.drive()
    core.late = True
    core.tick()
    assert not core.moving()
    assert core.only_fault(codes.TICK_STALLED)
    assert core.safety.state == codes.DISARMED
    assert core.safety.override == REASON + codes.TICK_STALLED
    core.run(100)
    core.late = False
    core.run(limits.TICK_STEADY_MS - 1)
    assert core.only_fault(codes.TICK_STALLED)
    core.tick()
    assert core.safety.faults == 0


def test_p10_an_exception_disarms_and_latches():
    core = Core()
    core.drive()
    core.safety.tick_raised()
    assert not core.safety.enable
    assert not core.safety.permitted
    assert core.only_fault(codes.TICK_EXCEPTION)
    assert core.safety.first_fault == REASON + codes.TICK_EXCEPTION
    assert core.safety.override == REASON + codes.TICK_EXCEPTION
    assert core.safety.arm_reason == REASON + codes.TICK_EXCEPTION
    core.run(1000)
    assert not core.moving()
    assert core.safety.override == REASON + codes.TICK_EXCEPTION
    assert core.only_fault(codes.TICK_EXCEPTION)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.tick()
    assert core.safety.faults == 0


def test_the_first_reason_is_kept():
    core = Core()
    core.drive()
    core.i.heading_faults = 1 << codes.HEADING_JUMP
    core.tick()
    core.i.heading_faults |= 1 << codes.HEADING_FROZEN
    core.tick()
    core.i.tilted = True
    core.tick()
    core.safety.tick_raised()
    core.tick()
    assert core.safety.first_fault == REASON + codes.HEADING_JUMP


# -- P11: emergency --------------------------------------------------------------------------------


def stopped_by_emergency(core):
    return (
        core.only_fault(codes.EMERGENCY)
        and core.safety.state == codes.DISARMED
        and not core.moving()
        and not core.toggled
    )


def open_input(core):
    core.emergency = True


def test_p11_input_or_message_stops_at_once_and_latches():
    for cause in (open_input, Core.emergency_message):
        core = Core()
        core.drive()
        cause(core)
        core.tick()
        assert stopped_by_emergency(core)
        assert core.safety.override == REASON + codes.EMERGENCY
        core.emergency = False
        core.run(5000)
        assert core.only_fault(codes.EMERGENCY)
        assert core.safety.arm_reason == REASON + codes.EMERGENCY


def test_p11_only_the_caretakers_order_resets_it():
    for owner, resets in ((0, False), (1, False), (2, True), (3, False)):
        core = Core()
        core.emergency_message()
        core.tick()
        core.order(codes.RESET_FAULTS, owner)
        core.tick()
        assert core.fault(codes.EMERGENCY) != resets
    for action in (codes.DISARM, codes.ARM, codes.EMERGENCY_STOP):
        core = Core()
        core.emergency_message()
        core.tick()
        core.order(action, codes.CARETAKER)
        core.tick()
        assert core.fault(codes.EMERGENCY)


def test_p11_a_reset_never_hides_an_emergency_of_the_same_tick():
    for cause in (open_input, Core.emergency_message):
        core = Core()
        core.drive()
        core.order(codes.RESET_FAULTS, codes.CARETAKER)
        cause(core)
        core.tick()
        assert stopped_by_emergency(core)
        core = Core()
        core.drive()
        core.button = True
        core.run(limits.RESET_PRESS_MS - 1)
        assert core.moving()
        cause(core)
        core.tick()
        assert stopped_by_emergency(core)


def test_p11_three_seconds_at_the_button_reset_once():
    core = Core()
    core.tick()
    core.emergency_message()
    core.button = True
    core.run(limits.RESET_PRESS_MS - 1)
    assert core.fault(codes.EMERGENCY)
    core.tick()
    assert not core.fault(codes.EMERGENCY)
    core.emergency_message()
    core.run(70000)
    assert core.fault(codes.EMERGENCY)  # held on: not again
    core.button = False
    core.tick()
    core.button = True
    core.run(limits.RESET_PRESS_MS - 1)
    core.button = False
    core.tick()
    core.button = True
    core.run(limits.RESET_PRESS_MS - 1)
    assert core.fault(codes.EMERGENCY)  # two short presses are not a long one


def test_p11_a_button_stuck_since_boot_resets_nothing():
    core = Core(boot_faults=1 << codes.EMERGENCY)
    core.button = True
    core.run(limits.RESET_PRESS_MS + 10)
    assert core.fault(codes.EMERGENCY)


# -- the relay -------------------------------------------------------------------------------------


def test_a_contact_open_for_25_ms_while_armed_disarms():
    core = Core()
    core.drive()
    for _ in range(3):
        core.contact = False
        core.run(limits.RELAY_RELEASE_MS - 1)
        assert core.moving()
        core.contact = True
        core.tick()
    core.contact = False
    core.run(limits.RELAY_RELEASE_MS)
    assert core.only_fault(codes.RELAY_OPEN)
    assert core.safety.state == codes.DISARMED
    core.run(limits.RELAY_CLEAR_MS - 1)
    assert core.only_fault(codes.RELAY_OPEN)
    core.tick()
    assert core.safety.faults == 0


def test_a_contact_that_stays_closed_is_a_fault_until_it_was_open_for_half_a_second():
    core = Core()
    core.drive()
    core.contact = True
    core.order(codes.DISARM)
    core.tick()
    assert core.safety.state == codes.DISARMED
    core.run(limits.RELAY_STUCK_MS - 1)
    assert core.safety.faults == 0
    core.tick()
    assert core.only_fault(codes.RELAY_STUCK)
    core.contact = False
    core.run(limits.RELAY_CLEAR_MS - 1)
    assert core.only_fault(codes.RELAY_STUCK)
    core.contact = True
    core.tick()
    core.contact = False
    core.run(limits.RELAY_CLEAR_MS - 1)
    assert core.only_fault(codes.RELAY_STUCK)
    core.tick()
    assert core.safety.faults == 0


def test_a_contact_closed_without_the_enable_line_is_stuck_after_100_ms():
    for before_ms in (0, 300):
        core = Core()
        core.run(before_ms)
        core.contact = True
        core.run(limits.RELAY_STUCK_MS - 1)
        assert core.safety.faults == 0
        core.tick()
        assert core.only_fault(codes.RELAY_STUCK)


def test_without_feedback_a_contact_that_rests_is_no_concern():
    for contact in (False, True):
        core = Core(relay_fitted=False)
        core.contact = contact
        core.run(700)
        assert core.safety.faults == 0
        core.drive()
        core.run(100)
        assert core.moving()


def test_without_feedback_a_contact_that_moves_is_a_fault_until_it_is_reset():
    for rests in (False, True):
        core = Core(relay_fitted=False)
        core.contact = rests
        core.drive()
        core.contact = not rests
        core.run(limits.RELAY_RELEASE_MS - 1)
        assert core.armed()
        core.tick()
        assert core.only_fault(codes.RELAY_UNEXPECTED)
        assert not core.armed() and not core.moving()
        core.release()
        core.run(1000)
        core.contact = rests
        core.run(1000)
        assert core.only_fault(codes.RELAY_UNEXPECTED)
        core.order(codes.RESET_FAULTS, codes.CARETAKER)
        core.run(600)
        assert core.safety.faults == 0
        core.drive()
    # Said to be fitted after all: it is judged as such.
    core.order(codes.DISARM)
    core.tick()
    core.contact = not rests
    core.safety.set_relay_fitted(True)
    core.run(30)
    assert not core.fault(codes.RELAY_UNEXPECTED)


def test_a_contact_that_bounces_is_not_one_that_moves():
    core = Core(relay_fitted=False)
    core.contact = False
    core.run(700)
    for _ in range(20):
        core.contact = True
        core.run(limits.RELAY_RELEASE_MS - 1)
        core.contact = False
        core.run(3)
    assert core.safety.faults == 0


def test_p11_a_latch_found_at_boot_outlives_the_first_tick():
    core = Core(boot_faults=1 << codes.EMERGENCY)
    core.i.session_count = 0  # nobody has spoken yet
    core.tick()
    assert core.fault(codes.EMERGENCY)


def test_an_unknown_tilt_stops_and_leaves_it_armed():
    core = Core()
    core.drive()
    core.i.service_faults = 1 << codes.TILT_UNKNOWN
    core.run(3)
    assert not core.moving()
    assert core.armed()


def test_what_a_contact_did_before_the_settings_changed_does_not_count():
    for closed in (False, True):
        core = Core(relay_fitted=False)
        core.safety.set_relay_fitted(False)
        core.contact = closed
        core.run(200)
        assert not core.fault(codes.RELAY_UNEXPECTED)
        core.contact = not closed
        core.run(200)
        assert core.fault(codes.RELAY_UNEXPECTED)
