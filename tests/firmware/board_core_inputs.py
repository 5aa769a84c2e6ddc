# The safety core, to the tick: silence of the host, the service loop, the lidar and the heading
# sensor, tilt, calibration.

from gazeboard.core import ages, limits
from gazeboard.core.safety import fault_reason
from gazelink import codes
from gazesim.core_rig import Core

REASON = codes.FAULT_REASON


def moves_again_with_a_new_press_only(core):
    # P14: armed still; the old press never moves again, a new one does at once.
    for _ in range(50):
        core.tick()
        assert not core.moving(), core.why()
    assert core.armed(), core.why()
    core.press(codes.FORWARD)
    core.tick()
    assert core.moving(), core.why()


def test_nothing_is_allowed_at_the_start():
    core = Core()
    s = core.safety
    assert (s.state, s.faults, s.first_fault, s.owner) == (0, 0, codes.NO_REASON, codes.NOBODY)
    assert not s.enable
    assert not s.permitted
    assert (s.override, s.arm_reason) == (codes.NO_REASON, codes.NOT_CONNECTED)
    assert (s.edge, s.spent_edge, s.ages.words[ages.TTL]) == (0, 0, 0)
    assert s.blocked == 15
    core.host = core.service = core.lidar = core.imu = False
    core.tick()
    assert s.faults == (
        (1 << codes.HOST_SILENT)
        | (1 << codes.SERVICE_STALLED)
        | (1 << codes.OBSTACLE_DATA_OLD)
        | (1 << codes.HEADING_BUS)
    )
    assert s.first_fault == REASON + codes.HOST_SILENT
    assert s.blocked == 15
    assert not core.toggled


def test_the_reason_of_faults_is_the_lowest_bit():
    last = len(codes.FAULTS) - 1
    assert fault_reason(0) == codes.NO_REASON
    for bit in range(len(codes.FAULTS)):
        assert fault_reason(1 << bit) == REASON + bit
        assert fault_reason((1 << bit) | (1 << last)) == REASON + bit
    assert fault_reason(1 << (last + 5)) == REASON + last  # never a reason that has no name


def test_faults_found_at_boot_stand_or_latch():
    for bit, stands in (
        (codes.NO_HARD_TIMER, True),
        (codes.EMERGENCY, False),
        (codes.WATCHDOG_BOOTS, False),
    ):
        core = Core(boot_faults=1 << bit)
        assert core.safety.faults == 1 << bit
        assert core.safety.first_fault == REASON + bit
        core.run(600)
        assert core.only_fault(bit)
        assert core.safety.arm_reason == REASON + bit
        core.order(codes.RESET_FAULTS, codes.CARETAKER)
        core.run(2)
        assert core.only_fault(bit) == stands


def test_the_first_tick_already_counts():
    core = Core(boot_faults=1 << codes.EMERGENCY)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)  # before the session: nobody's
    core.press(codes.FORWARD, hold_ms=0)
    core.tick()
    assert core.only_fault(codes.EMERGENCY)
    assert core.safety.ages.words[ages.TTL] == limits.COMMAND_TTL_MS - limits.MARGIN_MS
    assert core.safety.override == codes.NOT_ARMED


# -- P2, P9: the host, the service loop ------------------------------------------------------------


def test_p2_p9_silence_is_neutral_at_its_limit_and_disarms_at_the_next():
    for name, bit, limit_ms in (("host", codes.HOST_SILENT, 100), ("service", 1, 50)):
        core = Core()
        core.drive()
        core.hold_ms = 0
        core.command(300)
        setattr(core, name, False)
        core.run(limit_ms - limits.MARGIN_MS - 1)
        assert core.moving()
        assert core.safety.faults == 0
        core.tick()
        assert not core.moving()
        assert core.only_fault(bit)
        assert core.safety.override == REASON + bit
        core.run(500 - limit_ms - 1)
        assert core.armed()
        core.tick()
        assert core.safety.state == codes.DISARMED
        assert core.safety.owner == codes.NOBODY
        assert not core.toggled
        assert core.safety.override == REASON + bit  # still the reason why it stands
        setattr(core, name, True)
        core.run(3)
        assert core.safety.faults == 0
        assert core.safety.first_fault == REASON + bit  # kept for the explanation


def test_p2_p9_a_short_silence_needs_a_new_press_only():
    for name in ("host", "service"):
        core = Core()
        core.drive()
        setattr(core, name, False)
        core.run(150)
        setattr(core, name, True)
        moves_again_with_a_new_press_only(core)


# -- P6: obstacle data -----------------------------------------------------------------------------


def test_p6_obstacle_data_is_old_300_ms_after_acquisition_and_fresh_again_below_250():
    core = Core()
    core.drive()
    core.lidar = False
    core.i.clearance_age_ms = 40
    core.i.clearance_count += 1
    core.run(limits.CLEARANCE_OLD_MS - limits.MARGIN_MS - 40)
    assert core.moving()
    core.tick()
    assert not core.moving()
    assert core.only_fault(codes.OBSTACLE_DATA_OLD)
    assert core.safety.override == REASON + codes.OBSTACLE_DATA_OLD
    assert core.safety.blocked == 15
    for age_ms, old in ((248, True), (247, False), (297, False), (298, True), (60000, True)):
        core.i.clearance_age_ms = age_ms
        core.i.clearance_count += 1
        core.tick()
        assert core.fault(codes.OBSTACLE_DATA_OLD) == old, age_ms
    core.lidar = True
    core.i.clearance_age_ms = 0
    moves_again_with_a_new_press_only(core)


def test_p6_old_data_refuses_every_direction_with_its_reason():
    for verb in (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT):
        core = Core()
        core.arm()
        core.lidar = False
        core.run(limits.CLEARANCE_OLD_MS)
        core.press(verb)
        core.tick()
        assert not core.moving()
        assert core.safety.override == REASON + codes.OBSTACLE_DATA_OLD
        assert core.armed()


def test_p6_the_hysteresis_is_of_this_fault_alone():
    core = Core()
    core.i.tilted = True
    core.run(2)
    core.i.clearance_age_ms = limits.CLEARANCE_FRESH_MS
    core.run(2)
    assert core.only_fault(codes.TILT)


def test_data_of_a_simulation_never_moves_a_real_board():
    for source in (codes.SIMULATED, codes.REPLAYED):
        core = Core()
        core.drive()
        core.i.clearance_source = source
        core.tick()
        assert core.safety.state == codes.DISARMED
        assert core.only_fault(codes.SIMULATED_SOURCE)
        core.run(700)
        assert core.safety.arm_reason == REASON + codes.SIMULATED_SOURCE
        core.lidar = False
        core.run(400)
        assert core.only_fault(codes.OBSTACLE_DATA_OLD)  # there is no source any more
        core = Core(simulated=True)
        core.i.clearance_source = source
        core.drive()


def test_decisions_report_what_is_blocked():
    core = Core()
    core.i.tilted = True  # says nothing about obstacles
    for blocked in range(16):
        core.i.clearance_blocked = blocked | 0xF0
        core.see()
        assert core.safety.blocked == blocked
        for direction in range(4):
            decision = core.obstacles.decisions >> (2 * direction) & 3
            assert decision == (codes.BLOCKED if blocked >> direction & 1 else codes.FREE)


# -- P7: heading -----------------------------------------------------------------------------------


def test_p7_a_heading_without_samples_ends_turns_at_50_ms_and_nothing_else():
    for verb in (codes.LEFT, codes.RIGHT):
        core = Core()
        core.drive(verb)
        core.imu = False
        core.run(limits.HEADING_OLD_MS - limits.MARGIN_MS - 1)
        assert core.moving()
        core.tick()
        assert not core.moving()
        assert core.only_fault(codes.HEADING_BUS)
        assert core.safety.override == REASON + codes.HEADING_BUS
        assert core.armed()
        core.press(codes.FORWARD)
        core.tick()
        assert core.moving()


def test_p7_each_heading_fault_refuses_turns_with_its_reason():
    for bit in (3, 4, 5, 6):
        for verb, moves in (
            (codes.LEFT, False),
            (codes.RIGHT, False),
            (codes.FORWARD, True),
            (codes.BACKWARD, True),
        ):
            core = Core()
            core.arm()
            core.i.heading_faults = (1 << bit) | (1 << codes.WIPER) | 1  # only heading bits count
            core.press(verb)
            core.tick()
            assert core.only_fault(bit)
            assert core.moving() == moves
            assert core.safety.override == (codes.NO_REASON if moves else REASON + bit)
            core.i.heading_faults = 0
            core.tick()
            assert core.safety.faults == 0


# -- P16, calibration ------------------------------------------------------------------------------


def test_p16_tilt_is_neutral_with_the_reason_and_needs_a_new_press():
    core = Core()
    core.drive()
    core.i.tilted = True
    core.tick()
    assert not core.moving()
    assert core.only_fault(codes.TILT)
    assert core.safety.override == REASON + codes.TILT
    core.i.tilted = False
    core.tick()
    assert core.safety.faults == 0
    moves_again_with_a_new_press_only(core)


def test_without_calibration_it_disarms():
    core = Core()
    core.drive()
    core.i.calibrated = False
    core.tick()
    assert core.only_fault(codes.CALIBRATION)
    assert core.safety.state == codes.DISARMED


def test_counters_wrap_and_any_difference_counts():
    core = Core()
    core.i.host_count = core.i.service_count = 0xFFF0
    core.i.clearance_count = core.i.heading_count = 0xFFF0
    core.i.command_count = 0xFFFF
    core.drive()
    core.run(1000)
    assert core.moving()
    for counter in ("stop_count", "emergency_count", "session_count"):
        core = Core()
        setattr(core.i, counter, 0xFFFF)
        core.tick()
        core.order(codes.RESET_FAULTS, codes.CARETAKER)
        core.drive()
        setattr(core.i, counter, 1)
        core.tick()
        assert not core.moving(), counter
    core = Core()
    core.i.disarm_count = core.i.arm_count = core.i.reset_count = 0xFFFF
    core.tick()
    core.drive()
    assert core.i.arm_count == 0
    core.order(codes.DISARM)
    core.tick()
    assert core.i.disarm_count == 0
    assert core.safety.state == codes.DISARMED
    core.emergency_message()
    core.run(2)
    core.order(codes.RESET_FAULTS, codes.CARETAKER)
    core.tick()
    assert core.i.reset_count == 0
    assert core.safety.faults == 0
