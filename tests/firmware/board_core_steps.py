# Motions that end by themselves: steps, step turns and tuning pulses, to the tick.

from gazeboard.core import limits
from gazelink import codes
from motionrig import CAPS, TURNS, begun, outputs

LINEAR = (codes.FORWARD, codes.BACKWARD)


def test_p4_a_linear_step_ends_at_its_time():
    for verb in LINEAR:
        motion, i = begun(verb, codes.STEP)
        for _ in range(200):
            motion.step(i, 0, CAPS)
            assert motion.linear_permille
            assert not motion.ended
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (0, 0)
        assert motion.ended
        assert motion.end_reason == codes.NO_REASON
        assert motion.state == codes.STOPPED


def test_p4_a_turn_that_never_arrives_ends_at_its_limit():
    for verb in TURNS:
        motion, i = begun(verb, codes.STEP)
        for _ in range(300):
            motion.step(i, 0, CAPS)
            assert motion.turn_permille
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (0, 0)
        assert motion.ended
        assert motion.end_reason == codes.TIME_LIMIT


def test_two_seconds_before_its_limit_a_turn_is_asked_once_to_settle():
    for verb in TURNS:
        motion, i = begun(verb, codes.STEP)
        motion._settings.step_turn_limit_ms = 2700
        told = []
        for ms in range(1, 2701):
            motion.step(i, 0, CAPS)
            if motion._turn.settles > len(told):
                told.append(ms)
        assert told == [700]


def test_p4_ms_without_ticks_are_in_its_time():
    for missed in (1, 3, 19):
        for verb, mode, limit_ms in (
            (codes.FORWARD, codes.STEP, 200),
            (codes.BACKWARD, codes.STEP, 200),
            (codes.LEFT, codes.STEP, 300),
            (codes.FORWARD, codes.TUNE, 100),
            (codes.RIGHT, codes.TUNE, 100),
        ):
            motion, i = begun(verb, mode, 250, 250)
            i.pulse_ms = 100
            motion.step(i, 0, CAPS, 0, None, 1000)  # before it began: not of its time
            passed_ms = 0
            while not motion.ended:
                assert outputs(motion) != (0, 0)
                motion.step(i, 0, CAPS, 0, None, missed)
                passed_ms += 1 + missed
            assert limit_ms <= passed_ms <= limit_ms + missed


def test_a_turn_settles_once_also_when_its_moment_had_no_tick():
    for missed in (1, 3, 19):
        for early in range(missed + 2):
            motion, i = begun(codes.LEFT, codes.STEP)
            motion._settings.step_turn_limit_ms = 2700
            for _ in range(699 - early):
                motion.step(i, 0, CAPS)
            assert motion._turn.settles == 0
            motion.step(i, 0, CAPS, 0, None, missed)
            assert motion._turn.settles == (early <= missed)
            for _ in range(100):
                motion.step(i, 0, CAPS)
            assert motion._turn.settles == 1


def test_a_turn_that_arrives_ends_without_a_reason():
    for verb in TURNS:
        motion, i = begun(verb, codes.STEP)
        motion.end_reason = codes.TIME_LIMIT
        motion.step(i, 0, CAPS)
        motion._turn.arrived = True
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (0, 0)
        assert motion.ended
        assert motion.end_reason == codes.NO_REASON
        assert motion.state == codes.STOPPED


def test_a_turn_that_misses_its_setpoint_ends_as_if_late():
    motion, i = begun(codes.LEFT, codes.STEP)
    motion.step(i, 0, CAPS)
    motion._turn.missed = True
    motion.step(i, 0, CAPS)
    assert outputs(motion) == (0, 0)
    assert motion.ended
    assert motion.end_reason == codes.TIME_LIMIT


def test_a_step_turn_starts_from_the_present_heading():
    for verb, heading, setpoint in (
        (codes.LEFT, 1000, 1160),
        (codes.LEFT, 5700, 5860),
        (codes.RIGHT, 1000, 840),
        (codes.RIGHT, 100, -60),
    ):
        motion, i = begun(verb, codes.STEP)
        i.heading_q4 = heading
        i.rate_q4 = 7
        i.heading_count = 3
        motion.step(i, 0, CAPS)
        assert motion._turn.setpoint_q4 == setpoint
        assert motion._turn.seen == (heading, 7, 3)
        i.heading_q4 = 1100
        i.rate_q4 = 8
        i.heading_count = 4
        motion.step(i, 0, CAPS)
        assert motion._turn.setpoint_q4 == setpoint  # the same press, the same setpoint
        assert motion._turn.seen == (1100, 8, 4)


def arrived(motion, i, heading_q4):
    motion._turn.arrived = False
    motion.step(i, 0, CAPS)
    i.heading_q4 = heading_q4
    motion._turn.arrived = True
    motion.step(i, 0, CAPS)
    assert motion.ended
    motion.stop()
    i.edge += 1


def test_the_errors_of_step_turns_do_not_add_up():
    for verb, sign in ((codes.LEFT, 1), (codes.RIGHT, -1)):
        for rest_q4, counted in ((0, True), (9, True), (-32, True), (32, True), (33, False)):
            motion, i = begun(verb, codes.STEP)
            i.heading_q4 = 1000
            arrived(motion, i, 1000 + 160 * sign - rest_q4)
            motion.step(i, 0, CAPS)
            first_q4 = 1000 + 160 * sign
            start_q4 = first_q4 if counted else first_q4 - rest_q4
            assert motion._turn.setpoint_q4 == start_q4 + 160 * sign


def test_a_step_turn_counts_from_the_heading_after_anything_but_an_arrival():
    for spoil in (codes.FORWARD, codes.STOP):
        motion, i = begun(codes.LEFT, codes.STEP)
        i.heading_q4 = 1000
        if spoil == codes.STOP:  # ended before it arrived
            motion.step(i, 0, CAPS)
            motion.stop()
            i.edge += 1
            i.heading_q4 = 1150
        else:
            arrived(motion, i, 1150)
            i.verb = spoil
            motion.step(i, 0, CAPS)
            motion.stop()
            i.edge += 1
            i.verb = codes.LEFT
        motion._turn.arrived = False
        motion.step(i, 0, CAPS)
        assert motion._turn.setpoint_q4 == 1310


def test_only_step_turns_have_a_setpoint():
    for verb, mode in (
        (codes.FORWARD, codes.STEP),
        (codes.BACKWARD, codes.STEP),
        (codes.DRIVE, codes.STEP),
        (codes.LEFT, codes.CONTINUOUS),
        (codes.RIGHT, codes.CONTINUOUS),
    ):
        motion, i = begun(verb, mode)
        motion.step(i, 0, CAPS)
        assert motion._turn.setpoint_q4 is None
        assert motion._turn.seen is None


def test_a_step_straight_on_begins_and_ends_gently():
    for verb, sign in ((codes.FORWARD, 1), (codes.BACKWARD, -1)):
        motion, i = begun(verb, codes.STEP)
        motion._settings.step_ramp_ms = 50
        for ms in range(1, 201):
            motion.step(i, 0, CAPS)
            assert abs(motion.linear_permille) == min(600, 12 * ms, 12 * (201 - ms))
            assert motion.linear_permille * sign > 0
        motion.step(i, 0, CAPS)
        assert motion.ended


# -- a tuning pulse --------------------------------------------------------------------------------


def test_a_pulse_has_its_commanded_output_for_its_commanded_time():
    for verb, sign in ((codes.LEFT, 1), (codes.RIGHT, -1)):
        motion, i = begun(verb, codes.TUNE)
        i.turn_permille = 250
        i.pulse_ms = 100
        for _ in range(100):
            motion.step(i, 0, CAPS)
            assert outputs(motion) == (0, 250 * sign)
        motion.step(i, 0, CAPS)
        assert motion.ended
        assert motion.end_reason == codes.NO_REASON
        assert outputs(motion) == (0, 0)
    for verb, sign in ((codes.FORWARD, 1), (codes.BACKWARD, -1)):
        motion, i = begun(verb, codes.TUNE)
        i.linear_permille = -250  # the verb says which way
        i.pulse_ms = 100
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (250 * sign, 0)


def test_p4_a_pulse_is_never_longer_nor_wider_than_its_limits():
    motion, i = begun(codes.LEFT, codes.TUNE)
    i.turn_permille = 250
    i.pulse_ms = 65535
    for _ in range(limits.TUNE_PULSE_MAX_MS):
        motion.step(i, 0, CAPS)
        assert not motion.ended
    motion.step(i, 0, CAPS)
    assert motion.ended
    for angle_q4 in (480, -480):
        motion, i = begun(codes.LEFT, codes.TUNE)
        i.pulse_ms = 65535
        i.heading_q4 = 100
        motion.step(i, 0, CAPS)
        motion.step(i, 0, CAPS)
        assert not motion.ended
        i.heading_q4 = (i.heading_q4 + angle_q4) % 5760
        motion.step(i, 0, CAPS)
        assert motion.ended
        assert motion.end_reason == codes.TUNING_ANGLE
