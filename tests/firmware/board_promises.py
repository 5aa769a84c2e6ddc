# The safety promises P1 to P16 on the whole firmware in lockstep virtual time, one named test or
# more each. "Neutral" = both wipers read the stored centre; times count from the event on the
# board.

from boardtest import raises
from gazeboard import limits
from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazelink import codes, messages
from promises import CORE, kept, measured
from rig import IMU, NEUTRAL, POT, REGS, Files, Rig

ENABLE_AT = at.PINS_AT + pins.ENABLE * at.PIN_SIZE


def fault(rig, bit):
    return rig.app.safety.faults & (1 << bit) != 0


def armed(rig):
    return rig.app.safety.state == codes.ARMED


def toggles(rig, ms):
    # How often the enable line changed its level in the next `ms` ticks.
    count = 0
    level = rig.bank[ENABLE_AT + at.PIN_OUT]
    for _ in range(ms):
        rig.one_ms()
        if rig.bank[ENABLE_AT + at.PIN_OUT] != level:
            level = rig.bank[ENABLE_AT + at.PIN_OUT]
            count += 1
    return count


def stays_still_until_pressed_anew(rig):
    # P14: the press that was interrupted never moves the chair again, a new one does.
    for _ in range(400):
        rig.one_ms()
        assert rig.neutral(), rig.why()
    if not armed(rig):
        rig.release()
        rig.arm()
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)


# -- P1 --------------------------------------------------------------------------------------------


def test_p1_neutral_before_the_first_tick():
    rig = Rig()
    assert rig.neutral()  # the pot's own power-on value is 128, which is not neutral
    assert rig.bank[ENABLE_AT + at.PIN_OUT] == 0
    measured(CORE, "P1", "power-on: neutral, in ticks", rig.app.outbox.ticks, 0)


def test_p1_no_motion_and_no_enable_until_armed():
    rig = Rig()
    rig.press(codes.FORWARD)
    assert toggles(rig, 1500) == 0
    assert rig.neutral()
    assert rig.app.safety.override == codes.NOT_ARMED
    kept(CORE, "P1", "commands before the link is up")


def test_p1_a_reset_while_driving_comes_back_neutral_and_disarmed():
    rig = Rig()
    rig.drive()
    rig.boot()
    assert rig.neutral()
    assert toggles(rig, 500) == 0
    assert rig.app.safety.state == codes.DISARMED


# -- P2 --------------------------------------------------------------------------------------------


def test_p2_host_silent_is_neutral_within_100_ms_and_disarmed_after_500():
    for verb in (codes.FORWARD, codes.LEFT):
        rig = Rig()
        rig.drive(verb)
        rig.until(lambda: rig.now_ms % 20 == 0, 20)  # a frame was decoded in this very ms
        rig.host_alive = False
        ms = rig.until(rig.neutral, 200)
        measured(CORE, "P2", "host silent", ms, limits.HOST_SILENT_MS)
        ms += rig.until(lambda: not armed(rig), limits.HOST_LOST_MS)
        measured(CORE, "P2", "host silent: disarmed", ms, limits.HOST_LOST_MS)
        rig.host_alive = True
        stays_still_until_pressed_anew(rig)


def test_p2_a_short_silence_keeps_it_armed_but_needs_a_new_press():
    rig = Rig()
    rig.drive()
    rig.host_alive = False
    rig.run(200)
    rig.host_alive = True
    stays_still_until_pressed_anew(rig)
    assert armed(rig)


# -- P3 --------------------------------------------------------------------------------------------


def test_p3_a_command_not_refreshed_ends_within_300_ms():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig.hold = False  # the host lives and repeats the command, its time-to-live is spent
    ms = rig.until(rig.neutral, 400)
    measured(CORE, "P3", "hold not refreshed, page and host alive", ms, limits.COMMAND_TTL_MS)
    assert rig.app.safety.override == codes.COMMAND_EXPIRED
    rig.hold = True
    stays_still_until_pressed_anew(rig)


def test_p3_the_board_itself_counts_down():
    rig = Rig()
    rig.drive()
    rig.host_alive = False
    rig.app.safety._host_age_ms = 0
    moved = 0
    for _ in range(400):
        rig.app.safety._host_age_ms = 0  # only P3 is left to stop it
        rig.app.safety._clearance_age_ms = 0
        rig.one_ms()
        moved += not rig.neutral()
    measured(CORE, "P3", "the board alone counts down", moved, limits.COMMAND_TTL_MS)
    assert rig.app.safety.override == codes.COMMAND_EXPIRED


def test_p3_time_on_the_way_counts():
    rig = Rig()
    rig.arm()
    rig.host_alive = False
    rig.until(lambda: rig.now_ms % 10 == 1, 20)
    sent_at = rig.now_ms
    rig.send(messages.COMMAND, (codes.FORWARD, codes.CONTINUOUS, 9, codes.DRIVER, 300, 0, 0))
    held = bytes(rig.wire._to[rig.wire._tail : rig.wire._head])
    rig.wire.clear()
    rig.run(80)  # the frame waits 80 ms somewhere
    rig.wire.push(held, len(held))
    rig.app.safety._host_age_ms = 0
    for _ in range(400):
        rig.app.safety._host_age_ms = 0
        rig.app.safety._clearance_age_ms = 0
        rig.one_ms()
        if not rig.neutral():
            last = rig.now_ms
    measured(CORE, "P3", "time on the way counts", last - sent_at, limits.COMMAND_TTL_MS)


# -- P4 --------------------------------------------------------------------------------------------


def test_p4_a_forward_step_ends_by_itself():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD, codes.STEP)
    rig.until(lambda: not rig.neutral(), 60)
    moved = rig.until(rig.neutral, 6000)
    measured(CORE, "P4", "a step forward", moved, rig.app.settings.step_forward_ms + 1)
    assert rig.app.safety.override == codes.NO_REASON  # it ended as asked
    stays_still_until_pressed_anew(rig)


def test_p4_a_turn_that_never_arrives_ends_at_its_limit():
    rig = Rig()
    rig.arm()
    rig.press(codes.LEFT, codes.STEP)
    rig.until(lambda: not rig.neutral(), 60)
    moved = rig.until(rig.neutral, 11000)
    limit_ms = rig.app.settings.step_turn_limit_ms + 1
    measured(CORE, "P4", "a turn that never arrives", moved, limit_ms)
    assert rig.app.safety.override == codes.TIME_LIMIT


# -- P5, P6 ----------------------------------------------------------------------------------------


def test_p5_an_obstacle_on_the_path_stops_within_2_ms_with_the_reason():
    for verb, direction in (
        (codes.FORWARD, codes.DIR_FORWARD),
        (codes.BACKWARD, codes.DIR_BACKWARD),
        (codes.LEFT, codes.DIR_LEFT),
        (codes.RIGHT, codes.DIR_RIGHT),
    ):
        rig = Rig()
        rig.drive(verb)
        rig.blocked = 1 << direction
        rig.send(messages.CLEARANCE, (rig.blocked, codes.REAL, 5))
        ms = rig.until(rig.neutral, 10)
        measured(CORE, "P5", "obstacle on the path, from the decoded frame", ms, 2)
        assert rig.app.safety.override == codes.OBSTACLE_FORWARD + direction
        rig.run(20)
        assert rig.state["override"] == codes.OBSTACLE_FORWARD + direction
        rig.blocked = 0
        rig.run(100)
        assert rig.neutral()  # free again: still the old press
        stays_still_until_pressed_anew(rig)


def test_p5_an_obstacle_beside_the_path_does_not_stop():
    rig = Rig()
    rig.drive(codes.FORWARD)
    rig.blocked = 15 & ~(1 << codes.DIR_FORWARD)
    for _ in range(200):
        rig.one_ms()
        assert not rig.neutral()


def test_p5_a_turns_own_correction_only_goes_where_it_is_free():
    rig = Rig()
    rig.arm()
    rig.press(codes.LEFT, codes.STEP)
    rig.until(lambda: not rig.neutral(), 60)
    rig.heading_q4 += 320  # thrown past the setpoint in small, believable pieces
    rig.app._imu._monitor.restart()
    rig.blocked = 1 << codes.DIR_RIGHT
    for _ in range(300):
        rig.one_ms()
        assert rig.wipers()[1] >= NEUTRAL or rig.now_ms % 20 < 3


def test_p6_old_obstacle_data_counts_as_blocked_within_300_ms_of_acquisition():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 0, 20)
    rig.lidar_alive = False
    ms = 5 + rig.until(rig.neutral, 400)  # sent with an age of 5 ms
    measured(CORE, "P6", "obstacle data stays away", ms, limits.CLEARANCE_OLD_MS)
    assert rig.app.safety.override == codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
    rig.run(20)
    assert rig.state["decisions"] == 255
    rig.lidar_alive = True
    stays_still_until_pressed_anew(rig)


def test_p6_a_sender_whose_producer_died_does_not_keep_data_fresh():
    rig = Rig()
    rig.drive()
    rig.lidar_alive = False
    age = 5
    for _ in range(400):
        age += 1
        if rig.now_ms % 20 == 0:
            rig.send(messages.CLEARANCE, (0, codes.REAL, age))
        rig.one_ms()
        if not rig.neutral():
            moved_at = age
    cause = "lidar's process dead, the host goes on sending"
    measured(CORE, "P6", cause, moved_at + 1, limits.CLEARANCE_OLD_MS)


# -- P7 --------------------------------------------------------------------------------------------


def heading_fault_stops_turns(cause, spoil, bits):
    # Continuous turn: neutral within 50 ms of spoil(rig); forward stays possible, turns are
    # refused.
    rig = Rig()
    rig.arm()
    rig.rate_dps = 20.0
    rig.press(codes.LEFT)
    rig.run(300)
    assert not rig.neutral()
    spoil(rig)
    measured(CORE, "P7", cause, rig.until(rig.neutral, 60), limits.HEADING_OLD_MS)
    assert rig.app.safety.faults & codes.HEADING_FAULTS & bits, rig.why()
    assert rig.app.safety.override >= codes.FAULT_REASON
    assert armed(rig)
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)
    rig.press(codes.RIGHT)
    rig.until(rig.neutral, 60)
    return rig


def freeze(rig):
    rig.imu_alive = False


def nak(rig):
    rig.bank[IMU + at.SLOT_NAK] = 1


def stick(rig):
    rig.bank[at.BUSES_AT + pins.IMU_BUS * at.BUS_SIZE] = 1


def self_reset(rig):
    rig.imu_alive = False
    for k in range(0x14, 0x40):
        rig.bank[IMU + REGS + k] = 0


def jump(rig):
    rig.heading_q4 += 1440


def test_p7_a_frozen_heading():
    heading_fault_stops_turns("heading frozen", freeze, 1 << codes.HEADING_FROZEN)


def test_p7_a_bus_error():
    heading_fault_stops_turns("heading sensor answers nothing", nak, 1 << codes.HEADING_BUS)


def test_p7_a_stuck_bus():
    heading_fault_stops_turns("heading sensor's bus stuck", stick, 1 << codes.HEADING_BUS)


def test_p7_a_sensor_that_reset_itself():
    heading_fault_stops_turns("heading sensor resets itself", self_reset, codes.HEADING_FAULTS)


def test_p7_a_heading_that_jumps():
    heading_fault_stops_turns("heading jumps", jump, 1 << codes.HEADING_JUMP)


def test_p7_one_bad_sample_is_bridged_by_the_gyro():
    rig = Rig()
    rig.arm()
    rig.rate_dps = 20.0
    rig.press(codes.LEFT)
    rig.run(200)
    for _ in range(20):
        rig.until(lambda: rig.now_ms % 10 == 9, 20)
        rig.heading_q4 += 1000
        rig.one_ms()
        rig.heading_q4 -= 1000
        before = rig.app.inbox.front.heading_q4
        rig.run(99)
        assert not rig.neutral(), rig.why()
        moved = (rig.app.inbox.front.heading_q4 - before) % 5760
        assert 10 < moved < 60  # about 2 degrees in 100 ms at 20 degrees/s
    kept(CORE, "P7", "single bad samples are bridged")


def test_p7_the_sensor_comes_back_by_itself():
    for spoil in (freeze, nak, stick, jump, self_reset):
        rig = Rig()
        rig.arm()
        spoil(rig)
        rig.run(1000)
        rig.imu_alive = True
        rig.bank[IMU + at.SLOT_NAK] = 0
        rig.bank[at.BUSES_AT + pins.IMU_BUS * at.BUS_SIZE] = 0
        rig.until(lambda: rig.app.safety.faults == 0, 4000)
        rig.press(codes.LEFT)
        rig.until(lambda: not rig.neutral(), 60)


# -- P8 --------------------------------------------------------------------------------------------


def pot_nak(rig):
    rig.bank[POT + at.SLOT_NAK] = 1


def pot_bus(rig):
    rig.bank[at.BUSES_AT] = 1


def pot_misreads(rig):
    # The write reaches nothing: the registers stay what they were.
    rig.bank[POT + at.SLOT_STYLE] = at.STYLE_REGISTERS


def test_p8_a_failing_wiper_write_ends_the_enable_line_within_4_ms_and_latches():
    for spoil, cause in (
        (pot_nak, "potentiometer answers nothing"),
        (pot_bus, "potentiometer's bus stuck"),
        (pot_misreads, "potentiometer reads back wrong"),
    ):
        rig = Rig()
        rig.drive()
        spoil(rig)
        ms = rig.until(lambda: fault(rig, codes.WIPER), 10)
        measured(CORE, "P8", cause + ": enable off", ms, 4)
        assert toggles(rig, 50) == 0
        assert not armed(rig)
        rig.bank[POT + at.SLOT_NAK] = 0
        rig.bank[at.BUSES_AT] = 0
        rig.bank[POT + at.SLOT_STYLE] = at.STYLE_AD5282
        rig.release()
        rig.run(2000)
        assert fault(rig, codes.WIPER)  # latched
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.WIPER
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(100)
        rig.arm()


def test_p8_two_failures_in_a_row_are_retried():
    rig = Rig()
    rig.drive()
    for _ in range(50):
        rig.bank[POT + at.SLOT_NAK_COUNT] = 2  # two ticks, one transfer each
        rig.run(5)
    assert armed(rig)
    assert not rig.neutral()


# -- P9, P10 ---------------------------------------------------------------------------------------


def test_p9_a_stalled_service_loop_is_neutral_within_50_ms_and_disarmed_after_500():
    rig = Rig()
    rig.drive()
    rig.service_alive = False
    ms = rig.until(rig.neutral, 100)
    measured(CORE, "P9", "service loop blocked", ms, limits.SERVICE_STALLED_MS)
    ms += rig.until(lambda: not armed(rig), limits.SERVICE_LOST_MS)
    measured(CORE, "P9", "service loop blocked: disarmed", ms, limits.SERVICE_LOST_MS)
    rig.service_alive = True
    stays_still_until_pressed_anew(rig)


def test_p10_a_stalled_tick_stops_the_enable_line_and_disarms_when_it_returns():
    rig = Rig()
    rig.drive()
    level = rig.bank[ENABLE_AT + at.PIN_OUT]
    rig.clock.now_us += 25000
    assert rig.bank[ENABLE_AT + at.PIN_OUT] == level
    rig.one_ms()
    assert not armed(rig)
    assert fault(rig, codes.TICK_STALLED)
    assert rig.neutral()
    kept(CORE, "P10", "tick stalls: disarmed when it goes on")
    rig.release()
    rig.run(1000)
    stays_still_until_pressed_anew(rig)


def test_p10_an_exception_in_the_tick_turns_the_enable_line_off_and_latches():
    rig = Rig()
    rig.drive()
    step = rig.app.motion.step

    def broken(i, blocked):
        raise ValueError("spoilt")

    rig.app.motion.step = broken
    rig.one_ms()
    assert rig.bank[ENABLE_AT + at.PIN_OUT] == 0
    assert fault(rig, codes.TICK_EXCEPTION)
    measured(CORE, "P10", "exception inside the tick: enable off", 1, 1)
    rig.app.motion.step = step
    assert toggles(rig, 300) == 0
    assert rig.neutral()
    rig.release()
    rig.run(1500)
    assert fault(rig, codes.TICK_EXCEPTION)


def test_p10_the_watchdog_is_fed_only_while_the_tick_lives():
    rig = Rig()
    rig.run(100)
    feeds = rig.bank[at.WDT_FEEDS_AT]
    for _ in range(200):
        rig.app.service()
    assert rig.bank[at.WDT_FEEDS_AT] - feeds <= 1


# -- P11 -------------------------------------------------------------------------------------------


def open_input(rig):
    rig.drive_pin(pins.EMERGENCY, 1)


def broken_wire(rig):
    rig.bank[at.PINS_AT + pins.EMERGENCY * at.PIN_SIZE + at.PIN_HOST_DRIVE] = 0


def message(rig):
    rig.send(messages.ORDER, (codes.EMERGENCY_STOP, 200, codes.NOBODY))


def test_p11_emergency_input_or_message_turns_enable_off_within_2_ms_and_latches_across_resets():
    for cause in (open_input, broken_wire, message):
        rig = Rig()
        rig.drive()
        cause(rig)
        ms = rig.until(lambda: fault(rig, codes.EMERGENCY), 10)
        name = "emergency message" if cause is message else "emergency input"
        measured(CORE, "P11", name + ": enable off", ms, 2)
        assert rig.neutral()
        assert toggles(rig, 30) == 0
        rig.drive_pin(pins.EMERGENCY, 0)
        rig.release()
        rig.run(50)
        rig.boot()
        rig.run(1500)
        assert fault(rig, codes.EMERGENCY)
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        rig.give(codes.RESET_FAULTS, codes.DRIVER)
        rig.run(200)
        assert fault(rig, codes.EMERGENCY)  # the driver's page can't
        rig.give(codes.RESET_FAULTS, codes.CARETAKER)
        rig.run(200)
        assert not fault(rig, codes.EMERGENCY)
        rig.boot()
        rig.arm()


def test_p11_three_seconds_at_the_chairs_button_reset_it():
    rig = Rig()
    rig.drive()
    open_input(rig)
    rig.run(10)
    rig.release()
    rig.drive_pin(pins.BUTTON, 0)
    rig.run(3100)
    assert fault(rig, codes.EMERGENCY)  # the input is still open
    rig.drive_pin(pins.BUTTON, 1)
    rig.drive_pin(pins.EMERGENCY, 0)
    rig.run(50)
    rig.drive_pin(pins.BUTTON, 0)
    rig.run(2900)
    assert fault(rig, codes.EMERGENCY)
    rig.run(200)
    assert not fault(rig, codes.EMERGENCY)
    rig.arm()
    kept(CORE, "P11", "3 s at the chair's button reset it")


# -- P12 -------------------------------------------------------------------------------------------


def test_p12_every_single_bit_flip_of_a_command_is_ignored():
    rig = Rig()
    rig.arm()
    values = (codes.FORWARD, codes.CONTINUOUS, 77, codes.DRIVER, 300, 0, 0)
    messages.COMMAND.pack(rig.encoder.body, values)
    n = rig.encoder.finish(messages.COMMAND, rig.stamp)
    frame = bytes(rig.encoder.wire[:n])
    for bit in range(8 * n):
        spoilt = bytearray(frame)
        spoilt[bit >> 3] ^= 1 << (bit & 7)
        rig.wire.push(spoilt + b"\0", n + 1)
        rig.run(2)
        assert rig.neutral(), bit
    assert rig.app.link._decoder.corrupt >= 8 * n
    kept(CORE, "P12", "every single bit flip")


def test_p12_a_replayed_frame_never_moves():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD)
    rig.host_alive = False
    rig.speak()
    recorded = bytes(rig.wire._to[rig.wire._tail : rig.wire._head])
    rig.host_alive = True
    rig.until(lambda: not rig.neutral(), 60)
    rig.release()
    rig.run(400)
    for wait in (1, 50, 99, 100, 101, 1000):
        rig.wire.push(recorded, len(recorded))
        for _ in range(wait):
            rig.one_ms()
            assert rig.neutral()
    assert rig.app.link.stale > 0
    kept(CORE, "P12", "replayed frames")


def test_p12_frames_of_another_session_boot_or_version_are_ignored():
    from gazelink.frame import session_seed

    for seed in (session_seed(0x1235, 0x0B07), session_seed(0x1234, 0x0B08), b"\x01\x02\x03\x04"):
        rig = Rig()
        rig.arm()
        own = rig.encoder.seed
        rig.encoder.seed = seed
        values = (codes.FORWARD, codes.CONTINUOUS, 9, codes.DRIVER, 300, 0, 0)
        rig.send(messages.COMMAND, values)
        rig.encoder.seed = own
        corrupt = rig.app.link._decoder.corrupt
        rig.run(100)
        assert rig.neutral()
        assert rig.app.link._decoder.corrupt == corrupt + 1
    kept(CORE, "P12", "frames of a foreign session")


def test_p12_values_out_of_range_are_ignored_and_counted():
    rig = Rig()
    rig.arm()
    bad = 0
    for values in (
        (6, 1, 9, 1, 300, 0, 0),
        (255, 1, 9, 1, 300, 0, 0),
        (codes.FORWARD, 2, 9, 1, 300, 0, 0),
        (codes.DRIVE, 1, 9, 1, 300, 1001, 0),
        (codes.DRIVE, 1, 9, 1, 300, 0, -1001),
    ):
        rig.send(messages.COMMAND, values)
        bad += 1
        rig.run(3)
        assert rig.neutral()
    rig.send(messages.ORDER, (99, 7, 1))
    rig.send(messages.CLEARANCE, (0, 9, 0))
    rig.run(3)
    assert rig.app.link.bad == bad + 2
    kept(CORE, "P12", "values out of range")


def test_p12_frames_late_by_their_own_stamp_are_refused_but_a_late_stop_counts():
    rig = Rig()
    rig.arm()
    rig.host_alive = False
    stamp = rig.stamp
    rig.run(90)
    rig.stamp = stamp - 20
    rig.send(messages.COMMAND, (codes.FORWARD, codes.CONTINUOUS, 9, 1, 300, 0, 0))
    rig.send(messages.ORDER, (codes.ARM, 99, 1))
    rig.run(5)
    assert rig.neutral()
    rig.host_alive = True
    rig.run(200)
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)
    rig.stamp = (rig.stamp - 500) & 0xFFFF
    rig.send(messages.COMMAND, (codes.STOP, 0, 0, 0, 0, 0, 0))
    rig.until(rig.neutral, 2)


# -- P13 -------------------------------------------------------------------------------------------


def test_p13_only_the_owner_moves_and_anyones_stop_wins_in_one_tick():
    rig = Rig()
    rig.arm()
    rig.press(codes.FORWARD)
    rig.command = rig.command[:3] + (codes.CARETAKER, 0, 0)
    rig.run(200)
    assert rig.neutral()
    assert rig.app.safety.override == codes.NOT_OWNER
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)
    rig.until(lambda: rig.now_ms % 20 == 5, 20)
    rig.send(messages.COMMAND, (codes.STOP, 0, 0, codes.CARETAKER, 0, 0, 0))
    ms = rig.until(rig.neutral, 5)  # decoded after one tick, obeyed in the next
    measured(CORE, "P13", "anyone's stop, from its last byte", ms, 2)


def test_p13_a_stop_and_a_held_command_in_the_same_millisecond_stop():
    rig = Rig()
    rig.drive()
    rig.until(lambda: rig.now_ms % 20 == 5, 20)
    edge = rig.command[2]
    rig.send(messages.COMMAND, (codes.STOP, 0, 0, codes.CARETAKER, 0, 0, 0))
    rig.send(messages.COMMAND, (codes.FORWARD, codes.CONTINUOUS, edge, codes.DRIVER, 300, 0, 0))
    rig.until(rig.neutral, 2)
    stays_still_until_pressed_anew(rig)


def test_p13_hand_over_stops_first():
    rig = Rig()
    rig.drive()
    rig.give(codes.ARM, codes.CARETAKER)
    rig.until(rig.neutral, 25)
    assert rig.app.safety.owner == codes.CARETAKER
    assert armed(rig)


# -- P14, P15 --------------------------------------------------------------------------------------


def test_p14_a_new_session_disarms_and_needs_arming_and_a_new_press():
    rig = Rig()
    rig.drive()
    rig.encoder.seed = None
    rig.say_hello(0x4321)
    rig.until(rig.neutral, 2)
    assert not armed(rig)
    rig.run(600)
    assert rig.neutral()
    stays_still_until_pressed_anew(rig)
    kept(CORE, "P14", "a new session disarms")


def test_p14_arming_is_refused_with_the_reason_while_something_is_commanded():
    rig = Rig()
    rig.run(1200)
    rig.press(codes.FORWARD)
    rig.run(100)
    rig.give(codes.ARM)
    rig.run(300)
    assert not armed(rig)
    assert rig.state["arm_reason"] == codes.COMMAND_ACTIVE
    assert rig.neutral()


def test_p15_the_relay_opens_without_the_board_and_power_back_is_p1():
    rig = Rig()
    rig.drive()
    ms = 0
    while rig.relay_closed:  # no board: nothing toggles the line
        ms += 1
        rig.now_ms += 1
        rig._relay()
    measured(CORE, "P15", "power of the board pulled: relay open", ms, 20)
    rig.boot()
    assert rig.neutral()
    assert toggles(rig, 500) == 0


def test_a_relay_that_stays_open_or_closed_is_a_fault():
    rig = Rig()
    rig.relay_works = False
    rig.run(1200)
    rig.give(codes.ARM)
    rig.run(300)
    assert not armed(rig)
    assert rig.app.safety.faults & (1 << codes.RELAY_OPEN)
    rig = Rig()
    rig.drive()
    rig.relay_works = False  # opens while driving
    rig.until(lambda: fault(rig, codes.RELAY_OPEN), limits.RELAY_RELEASE_MS + 5)
    assert rig.neutral()
    rig = Rig()
    rig.run(1200)
    rig._relay = lambda: rig.drive_pin(pins.RELAY_FEEDBACK, 0)  # welded
    rig.run(limits.RELAY_STUCK_MS + 5)
    assert fault(rig, codes.RELAY_STUCK)
    rig.give(codes.ARM)
    rig.run(200)
    assert not armed(rig)


# -- P16 -------------------------------------------------------------------------------------------


def test_p16_tilt_is_neutral_within_100_ms_with_the_reason():
    for register in (0x1C, 0x1E):
        for degrees in (20, -20):
            rig = Rig()
            rig.drive()
            q4 = (degrees * 16) & 0xFFFF
            rig.bank[IMU + REGS + register] = q4 & 0xFF
            rig.bank[IMU + REGS + register + 1] = q4 >> 8
            ms = rig.until(rig.neutral, 200)
            measured(CORE, "P16", "tilt beyond the limit", ms, limits.TILT_MS)
            assert rig.app.safety.override == codes.FAULT_REASON + codes.TILT
            rig.bank[IMU + REGS + register] = 0
            rig.bank[IMU + REGS + register + 1] = 0
            stays_still_until_pressed_anew(rig)


# -- arming ----------------------------------------------------------------------------------------


def test_arming_says_what_is_missing():
    rig = Rig()
    rig.host_alive = False
    rig.run(600)
    assert rig.app.safety.arm_reason == codes.NOT_CONNECTED
    rig = Rig()
    rig.lidar_alive = False
    rig.run(1200)
    assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.OBSTACLE_DATA_OLD
    files = Files()
    files.texts["settings.json"] = "spoilt"
    rig = Rig(0, files)
    rig.run(1200)
    assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.CALIBRATION
    assert "damaged" in rig.app.settings.error
    rig = Rig()
    rig.run(400)
    assert rig.app.safety.arm_reason == codes.NEUTRAL_NOT_PROVEN
    rig = Rig()
    rig.run(1200)
    rig.give(codes.ARM, codes.NOBODY)
    rig.run(200)
    assert not armed(rig)


def test_a_real_board_never_arms_behind_simulated_or_replayed_data():
    for source in (codes.SIMULATED, codes.REPLAYED):
        rig = Rig()
        rig.source = source
        rig.app.safety._simulated_board = False
        rig.run(1200)
        rig.give(codes.ARM)
        rig.run(300)
        assert not armed(rig)
        assert rig.state["arm_reason"] == codes.FAULT_REASON + codes.SIMULATED_SOURCE


def test_the_clocks_wrap_changes_nothing():
    rig = Rig((1 << 30) - 2000000)
    rig.drive()
    for _ in range(2500):
        rig.one_ms()
        assert not rig.neutral()
        assert rig.app.safety.faults == 0, rig.why()
    assert rig.clock.ticks_us() < 3000000  # it has wrapped
    rig.app.outbox.ticks = (1 << 30) - 300
    rig.run(20)
    rig.press(codes.LEFT)
    rig.run(600)
    assert armed(rig), rig.why()
    assert rig.app.safety.faults == 0
    assert rig.app.outbox.ticks < 10000


def test_a_host_that_stops_reading_delays_nothing():
    rig = Rig()
    rig.drive()
    rig.wire.reading = False
    # No fresh stamp reaches the host, so its commands age by our clock: stale after 100 ms, and
    # what was left of their life then ends as if the driver had let go.
    stopped = rig.until(rig.neutral, 400)
    assert limits.FRAME_STALE_MS < stopped <= limits.COMMAND_TTL_MS + 10
    assert rig.app.telemetry.dropped > 0
    rig.wire.reading = True
    stays_still_until_pressed_anew(rig)


def test_raises_is_used_for_refusals():
    # A first command before any HELLO is garbage to the board; the host's own encoder refuses it.
    rig = Rig()
    assert "no session" in raises(ValueError, rig.send, messages.COMMAND, (1, 1, 1, 1, 300, 0, 0))
