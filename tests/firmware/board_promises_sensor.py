# Promises P7 and P16 on the whole firmware in lockstep virtual time: heading and tilt.

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.core import limits
from gazelink import codes
from gazesim.board_rig import IMU, NEUTRAL, REGS, Rig
from promiserig import armed, stays_still_until_pressed_anew
from promises import CORE, kept, measured


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


def test_a_bus_that_failed_for_a_moment_is_trusted_after_half_a_second():
    rig = Rig()
    rig.arm()
    nak(rig)
    rig.until(lambda: rig.app.safety.faults == 1 << codes.HEADING_BUS, 60)
    rig.bank[IMU + at.SLOT_NAK] = 0
    for _ in range(490):
        rig.one_ms()
        assert rig.app.safety.faults == 1 << codes.HEADING_BUS, rig.why()
    rig.until(lambda: rig.app.safety.faults == 0, 60)


# The sensor goes, and counts from another zero when it is back.
def goes(rig):
    nak(rig)


def resets(rig):
    self_reset(rig)


def comes_back(rig):
    rig.heading_q4 += 1440
    rig.imu_alive = True
    rig.bank[IMU + at.SLOT_NAK] = 0


def stays_straight(rig, ms):
    for _ in range(ms):
        rig.one_ms()
        linear, turn = rig.wipers()
        assert turn == NEUTRAL, rig.why()
        assert linear > NEUTRAL, rig.why()


def test_p7_another_zero_of_the_heading_turns_no_motion_straight_ahead():
    for verb in (codes.FORWARD, codes.DRIVE):
        for mode in (codes.CONTINUOUS, codes.AUTO) if verb == codes.DRIVE else (codes.CONTINUOUS,):
            for spoil, back in ((jump, None), (goes, comes_back), (resets, comes_back)):
                for pressed_before in (True, False):
                    rig = Rig()
                    rig.arm()
                    if pressed_before:
                        straight(rig, verb, mode)
                    spoil(rig)
                    rig.run(200)
                    assert rig.app.safety.faults & codes.HEADING_FAULTS
                    if not pressed_before:
                        straight(rig, verb, mode)
                    if back is not None:
                        back(rig)
                    stays_straight(rig, 2500)
                    assert rig.app.safety.faults == 0, rig.why()


def straight(rig, verb, mode):
    rig.press(verb, mode, 300)
    rig.watched = mode == codes.AUTO
    rig.run(60)
    assert not rig.neutral(), rig.why()


def test_a_heading_that_came_back_is_held_again():
    for verb in (codes.FORWARD, codes.DRIVE):
        rig = Rig()
        rig.arm()
        straight(rig, verb, codes.CONTINUOUS)
        jump(rig)
        stays_straight(rig, 1000)
        assert rig.app.safety.faults == 0
        rig.rate_dps = 10.0  # the floor turns it to the left
        rig.run(500)
        assert rig.wipers()[1] < NEUTRAL


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
