# Promises P7 and P16 where they meet: tilt and heading at every moment of the sampling, with reads
# lost, and what a chair does whose tilt cannot be read.

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.core import limits
from gazelink import codes
from gazesim.board_rig import IMU, NEUTRAL, REGS, Rig
from promiserig import armed, fault, stays_still_until_pressed_anew
from promises import CORE, kept, measured

_ROTA_MS = 80  # longer than any round of the sensor's reads
_LATER_MS = (0, 3, 9, 17, 23, 31, 38, 44)  # after the event: when a single read is lost
_TILTS = ((0x1C, 30), (0x1E, -30))


def tilt(rig, degrees, register=0x1E):
    q4 = int(degrees * 16) & 0xFFFF
    rig.bank[IMU + REGS + register] = q4 & 0xFF
    rig.bank[IMU + REGS + register + 1] = q4 >> 8


def lose_reads(rig, count):
    rig.bank[IMU + at.SLOT_NAK_COUNT] = count


def nak(rig):
    rig.bank[IMU + at.SLOT_NAK] = 1


def stick(rig):
    rig.bank[at.BUSES_AT + pins.IMU_BUS * at.BUS_SIZE] = 1


def freeze(rig):
    rig.imu_alive = False


def self_reset(rig):
    rig.imu_alive = False
    for k in range(0x14, 0x40):
        rig.bank[IMU + REGS + k] = 0


def heal(rig):
    rig.imu_alive = True
    rig.bank[IMU + at.SLOT_NAK] = 0
    rig.bank[at.BUSES_AT + pins.IMU_BUS * at.BUS_SIZE] = 0


DEAD = (nak, stick, freeze, self_reset)


def until(rig, condition, limit_ms, lost_at_ms=None, lost=1):
    for ms in range(limit_ms + 1):
        if condition():
            return ms
        if ms == lost_at_ms:
            lose_reads(rig, lost)
        rig.one_ms()
    return limit_ms + 1


def moves_again(rig):
    # A chair that stood takes a new press.
    if not armed(rig):
        rig.release()
        rig.arm()
    rig.press(codes.FORWARD)
    rig.until(lambda: not rig.neutral(), 60)


def test_p16_at_every_moment_of_the_sampling():
    worst_ms = 0
    rig = Rig()
    rig.drive()
    for phase in range(_ROTA_MS):
        register, degrees = _TILTS[phase & 1]
        rig.until(lambda: rig.app._imu.samples % 64 == (60 + phase // 10) % 64, 700)
        rig.run(phase % 10)
        assert not rig.neutral(), rig.why()
        tilt(rig, degrees, register)
        worst_ms = max(worst_ms, until(rig, rig.neutral, 200))
        tilt(rig, 0, register)
        rig.until(lambda: not fault(rig, codes.TILT), 600)
        moves_again(rig)
    measured(CORE, "P16", "tilt beyond the limit, at any moment", worst_ms, limits.TILT_MS)


def test_p16_with_a_single_read_lost():
    worst_ms = 0
    rig = Rig()
    rig.drive()
    for phase in range(0, 40, 3):
        for lost_at_ms in _LATER_MS:
            rig.run(phase)
            tilt(rig, 30)
            worst_ms = max(worst_ms, until(rig, rig.neutral, 200, lost_at_ms))
            tilt(rig, 0)
            rig.until(lambda: not fault(rig, codes.TILT), 600)
            moves_again(rig)
    measured(CORE, "P16", "tilt beyond the limit, a read lost", worst_ms, limits.TILT_MS)


def test_p16_with_a_sensor_that_answers_now_and_then():
    # Two looks are enough, however far apart they are.
    rig = Rig()
    rig.drive()
    for phase in range(0, 60, 7):
        rig.run(phase)
        tilt(rig, 30)
        ms = 0
        while not rig.neutral():
            rig.bank[IMU + at.SLOT_NAK] = 0 if ms % 60 < 11 else 1
            rig.one_ms()
            ms += 1
            assert ms <= 60 + 2 * limits.HEADING_OLD_MS, rig.why()
        heal(rig)
        tilt(rig, 0)
        rig.until(lambda: rig.app.safety.faults == 0, 3000)
        moves_again(rig)


def test_p16_single_spikes_move_nothing():
    rig = Rig()
    rig.drive()
    for _ in range(20):
        rig.until(lambda: rig.now_ms % 10 == 9, 20)
        tilt(rig, 80)
        rig.run(10)
        tilt(rig, 0)
        rig.run(50)
        assert not rig.neutral(), rig.why()


def test_p16_seen_before_the_sensor_died_stays():
    for die in DEAD:
        rig = Rig()
        rig.drive()
        tilt(rig, 20)
        rig.until(rig.neutral, limits.TILT_MS)
        die(rig)
        for _ in range(3000):
            rig.one_ms()
            assert rig.neutral(), rig.why()
            if rig.now_ms % 100 == 0:
                rig.press(codes.BACKWARD if rig.now_ms % 200 else codes.FORWARD)
        heal(rig)
        tilt(rig, 0)
        rig.until(lambda: rig.app.safety.faults == 0, 4000)
        stays_still_until_pressed_anew(rig)


def test_p16_a_dead_sensor_on_ground_that_was_not_level_is_neutral():
    # Half the limit is no level ground: nobody knows what comes after it.
    for die in DEAD:
        rig = Rig()
        rig.drive()
        tilt(rig, 10)
        rig.run(400)
        assert not rig.neutral()
        die(rig)
        measured(
            CORE,
            "P16",
            "tilt cannot be read, not level",
            until(rig, rig.neutral, 200),
            limits.TILT_MS,
        )
        assert rig.app.safety.override == codes.FAULT_REASON + codes.TILT_UNKNOWN
        rig.press(codes.FORWARD)
        rig.run(300)
        assert rig.neutral()
        assert armed(rig)


def test_p16_a_dead_sensor_creeps_a_little_on_level_ground_and_then_stands():
    for die in DEAD:
        for verb in (codes.FORWARD, codes.BACKWARD):
            rig = Rig()
            rig.drive(verb)
            direction = codes.DIR_FORWARD if verb == codes.FORWARD else codes.DIR_BACKWARD
            creep = rig.app.obstacles._stopping[direction].permille[0] * 84 // 1000
            die(rig)
            if die in (nak, stick):
                tilt(rig, 30)  # nobody can see it
            rig.run(limits.TILT_MS)
            moved_ms = 0
            for _ in range(20000):
                rig.one_ms()
                linear, turn = rig.wipers()
                assert -creep <= linear - NEUTRAL <= creep, (rig.why(), creep)
                assert turn == NEUTRAL
                moved_ms += not rig.neutral()
                if rig.now_ms % 1000 == 0:
                    rig.press(verb)
            measured(
                CORE,
                "P16",
                "tilt cannot be read: creeps, until neutral",
                moved_ms + limits.TILT_MS,
                limits.TILT_UNSEEN_MS,
            )
            assert moved_ms > limits.TILT_UNSEEN_MS - 2 * limits.TILT_MS  # forward stays possible
            assert rig.app.safety.override == codes.FAULT_REASON + codes.TILT_UNKNOWN
            assert armed(rig)


def test_p16_level_ground_is_forgotten():
    rig = Rig()
    rig.arm()
    nak(rig)
    rig.run(limits.TILT_FORGOTTEN_MS + 200)
    rig.press(codes.FORWARD)
    rig.run(300)
    assert rig.neutral()
    assert rig.app.safety.override == codes.FAULT_REASON + codes.TILT_UNKNOWN


def test_p16_after_the_sensor_is_back_it_drives_as_before():
    rig = Rig()
    rig.drive()
    before = rig.wipers()[0]
    nak(rig)
    rig.run(1000)
    assert NEUTRAL < rig.wipers()[0] < before
    heal(rig)
    rig.until(lambda: rig.app.safety.faults == 0, 4000)
    rig.until(lambda: rig.wipers()[0] == before, 100)  # slowed down only: goes on by itself


def test_p16_zeros_of_a_sensor_that_reset_itself_are_no_level_ground():
    rig = Rig()
    rig.drive()
    tilt(rig, 20)
    rig.until(rig.neutral, limits.TILT_MS)
    self_reset(rig)
    rig.run(200)
    for _ in range(50):
        rig.press(codes.FORWARD)
        rig.run(40)
        assert rig.neutral(), rig.why()


MOTIONS = (
    (codes.LEFT, codes.CONTINUOUS, 0, 0),
    (codes.RIGHT, codes.STEP, 0, 0),
    (codes.DRIVE, codes.CONTINUOUS, 400, 300),
    (codes.DRIVE, codes.CONTINUOUS, 0, -300),
    (codes.DRIVE, codes.CONTINUOUS, -400, 60),
    (codes.FORWARD, codes.CONTINUOUS, 0, 0),
    (codes.FORWARD, codes.STEP, 0, 0),
)


def turns(rig):
    return rig.wipers()[1] != NEUTRAL


def start(rig, motion):
    verb, mode, linear, turn = motion
    heal(rig)
    rig.release()
    rig.rate_dps = 0.0
    rig.until(lambda: rig.app.safety.faults == 0, 5000)
    rig.press(verb, mode, linear, turn)
    rig.rate_dps = 0.5
    rig.until(lambda: turns(rig) if verb != codes.FORWARD else not rig.neutral(), 200)
    if verb == codes.FORWARD:
        rig.heading_q4 += 40  # beside its heading: it holds
        rig.until(lambda: turns(rig), 200)


def test_p7_a_frozen_heading_in_every_motion_that_turns():
    rig = Rig()
    rig.arm()
    for motion in MOTIONS:
        worst_ms = 0
        for phase in (0, 3, 6, 9):
            for lost_at_ms in (None, 3, 31, 44):
                start(rig, motion)
                rig.run(phase)
                assert turns(rig), rig.why()
                freeze(rig)
                ms = until(rig, lambda: not turns(rig), 200, lost_at_ms)
                worst_ms = max(worst_ms, ms)
                for _ in range(100):
                    rig.one_ms()
                    assert not turns(rig)
        name = "heading frozen during " + codes.VERBS[motion[0]]
        measured(CORE, "P7", name, worst_ms, limits.HEADING_OLD_MS)


def test_p7_a_heading_frozen_at_rest_turns_for_no_press_50_ms_later():
    for rest_ms in range(limits.HEADING_OLD_MS, 130, 7):
        rig = Rig()
        rig.arm()
        freeze(rig)
        rig.run(rest_ms - 20)
        rig.press(codes.LEFT)
        rig.run(20)
        for _ in range(200):
            rig.one_ms()
            assert not turns(rig), rest_ms
    kept(CORE, "P7", "heading frozen at rest: no press turns")


def test_p7_a_heading_that_stands_while_the_gyro_turns():
    for dps in (-40.0, 25.0, 60.0):
        rig = Rig()
        rig.arm()
        rig.rate_dps = dps
        rig.press(codes.LEFT)
        rig.run(300)
        stood = rig.heading_q4
        ms = 0
        while not rig.neutral():
            rig.heading_q4 = stood - dps * 16 / 100 if rig.now_ms % 10 == 9 else rig.heading_q4
            rig.one_ms()
            ms += 1
            assert ms < 120, dps
        cause = "heading stands still, gyro turns %d degrees/s" % abs(int(dps))
        measured(CORE, "P7", cause, ms, 50 + 2500 // abs(int(dps)))
