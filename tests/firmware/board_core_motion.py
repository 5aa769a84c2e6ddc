# Motion to the tick: outputs of every verb and mode, ends of steps, limits, no way into a blocked
# turn.

from corerig import Turn
from gazeboard.core import limits
from gazeboard.core.motion import Motion
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazelink import codes

LINEAR = (codes.FORWARD, codes.BACKWARD)
TURNS = (codes.LEFT, codes.RIGHT)
ALL = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE)
CAPS = (1000, 1000, 1000, 1000)
LEFT_BIT = 1 << codes.DIR_LEFT
RIGHT_BIT = 1 << codes.DIR_RIGHT


def begun(verb, mode, linear=0, turn=0):
    i = Inputs()
    i.cap_permille = 1000
    i.verb = verb
    i.mode = mode
    i.edge = 1
    i.linear_permille = linear
    i.turn_permille = turn
    settings = Settings()
    settings.linear_permille = 600
    settings.turn_permille = 500
    settings.step_forward_ms = 200
    settings.step_ramp_ms = 0
    settings.hold_permille = 150
    settings.step_turn_limit_ms = 300
    settings.step_turn_q4_deg = 160
    return Motion(settings, Turn()), i


def outputs(motion):
    return (motion.linear_permille, motion.turn_permille)


def test_it_starts_at_rest():
    motion, _ = begun(codes.FORWARD, codes.STEP)
    assert outputs(motion) == (0, 0)
    assert motion.state == codes.STOPPED
    assert not motion.ended
    assert motion.end_reason == codes.NO_REASON


def test_every_verb_has_its_output_and_word():
    for mode in (codes.STEP, codes.CONTINUOUS):
        for verb, expected, word in (
            (codes.FORWARD, (600, 0), codes.MOVING_FORWARD),
            (codes.BACKWARD, (-600, 0), codes.MOVING_BACKWARD),
            (codes.LEFT, (0, 500), codes.TURNING),
            (codes.RIGHT, (0, -500), codes.TURNING),
            (codes.DRIVE, (250, -120), codes.DRIVING),
        ):
            motion, i = begun(verb, mode, 250, -120)
            motion._turn.out = 500 if verb == codes.LEFT else -500
            motion.step(i, 0, CAPS)
            assert outputs(motion) == expected
            assert motion.state == word
            assert not motion.ended


def test_outputs_stay_within_the_settings():
    for linear in (-1000, -601, -600, 0, 600, 601, 1000):
        for turn in (-1000, -501, -500, 0, 500, 501, 1000):
            motion, i = begun(codes.DRIVE, codes.CONTINUOUS, linear, turn)
            motion.step(i, 0, CAPS)
            assert outputs(motion) == (max(-600, min(600, linear)), max(-500, min(500, turn)))
    motion, i = begun(codes.LEFT, codes.STEP)
    for out in (-9999, 9999):
        motion._turn.out = out
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (0, 1000 if out > 0 else -1000)


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


def test_two_seconds_before_its_limit_a_turn_is_told_to_settle_once():
    for verb in TURNS:
        motion, i = begun(verb, codes.STEP)
        motion._settings.step_turn_limit_ms = 2700
        told = []
        for ms in range(1, 2701):
            motion.step(i, 0, CAPS)
            if motion._turn.settles > len(told):
                told.append(ms)
        assert told == [700]


def test_a_turn_that_arrives_has_ended_as_asked():
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


def test_a_held_motion_has_no_end_of_its_own():
    for verb in ALL:
        motion, i = begun(verb, codes.CONTINUOUS, 100, 100)
        for _ in range(1000):
            motion.step(i, 0, CAPS)
            assert outputs(motion) != (0, 0)
            assert not motion.ended


def test_a_step_turn_starts_from_the_present_heading():
    for verb, setpoint in ((codes.LEFT, 1160), (codes.RIGHT, 840)):
        motion, i = begun(verb, codes.STEP)
        i.heading_q4 = 1000
        i.rate_q4 = 7
        i.heading_count = 3
        motion.step(i, 0, CAPS)
        assert motion._turn.setpoint_q4 == setpoint
        assert motion._turn.seen == (1000, 7, 3)
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


def test_what_a_step_turn_leaves_does_not_add_up():
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


def test_no_turn_into_a_blocked_side():
    for verb in TURNS:
        for mode in (codes.STEP, codes.CONTINUOUS):
            for out in (-300, 300):
                motion, i = begun(verb, mode)
                motion._turn.out = out
                motion.step(i, 0, CAPS)
                free = motion.turn_permille
                assert free
                for blocked in range(16):
                    motion.step(i, blocked, CAPS)
                    against = LEFT_BIT if free > 0 else RIGHT_BIT
                    assert motion.turn_permille == (0 if blocked & against else free)


def test_not_by_the_smallest_output():
    for turn in (-1, 1):
        motion, i = begun(codes.DRIVE, codes.CONTINUOUS, 0, turn)
        motion.step(i, 0, CAPS)
        assert motion.turn_permille == turn
        motion.step(i, LEFT_BIT | RIGHT_BIT, CAPS)
        assert motion.turn_permille == 0


def test_stop_is_neutral_and_forgets():
    motion, i = begun(codes.LEFT, codes.STEP)
    for _ in range(300):
        motion.step(i, 0, CAPS)
    motion.stop()
    assert outputs(motion) == (0, 0)
    assert motion.state == codes.STOPPED
    i.heading_q4 = 2000
    for _ in range(300):  # the same press number: begun anew, with its own time and setpoint
        motion.step(i, 0, CAPS)
        assert not motion.ended
    assert motion._turn.setpoint_q4 == 2160
    motion.step(i, 0, CAPS)
    assert motion.ended
    motion.stop()
    assert not motion.ended


def test_stop_while_moving_straight():
    motion, i = begun(codes.DRIVE, codes.CONTINUOUS, 300, 200)
    motion.step(i, 0, CAPS)
    motion.stop()
    assert outputs(motion) == (0, 0)
    assert motion.state == codes.STOPPED


def test_a_new_press_begins_anew():
    motion, i = begun(codes.FORWARD, codes.STEP)
    for _ in range(201):
        motion.step(i, 0, CAPS)
    assert motion.ended
    for edge in (2, 1):  # any other number
        motion, i = begun(codes.FORWARD, codes.STEP)
        i.edge = 3 - edge
        motion.step(i, 0, CAPS)
        i.edge = edge
        i.verb = codes.BACKWARD
        motion.step(i, 0, CAPS)
        assert motion.state == codes.MOVING_BACKWARD
    motion, i = begun(codes.FORWARD, codes.STEP)
    for _ in range(201):
        motion.step(i, 0, CAPS)
    assert motion.ended
    i.edge = 2
    i.verb = codes.BACKWARD
    for _ in range(200):
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (-600, 0)
        assert not motion.ended
        assert motion.state == codes.MOVING_BACKWARD
    motion.step(i, 0, CAPS)
    assert motion.ended


def test_an_axis_that_is_not_asked_for_is_neutral():
    motion, i = begun(codes.DRIVE, codes.CONTINUOUS, 300, 200)
    motion.step(i, 0, CAPS)
    i.edge = 2
    i.verb = codes.FORWARD
    motion.step(i, 0, CAPS)
    assert outputs(motion) == (600, 0)
    i.edge = 3
    i.verb = codes.RIGHT
    motion.step(i, 0, CAPS)
    assert outputs(motion) == (0, -500)


def test_what_is_put_out_is_followed():
    motion, i = begun(codes.LEFT, codes.STEP)
    motion._turn.out = 9999
    motion.step(i, 0, CAPS)
    assert motion._turn.followed == 1000
    motion.step(i, LEFT_BIT, CAPS)
    assert motion._turn.followed == 0
    motion.step(i, 0, CAPS)
    motion.stop()
    assert motion._turn.followed == 0


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


def test_a_held_motion_is_at_its_output_at_once():
    motion, i = begun(codes.FORWARD, codes.CONTINUOUS)
    motion._settings.step_ramp_ms = 50
    motion.step(i, 0, CAPS)
    assert outputs(motion) == (600, 0)


def test_going_forward_keeps_the_heading_of_the_press():
    for mode in (codes.STEP, codes.CONTINUOUS):
        for held, out in ((70, 70), (-70, -70), (9999, 150), (-9999, -150)):
            motion, i = begun(codes.FORWARD, mode)
            motion._turn.held = held
            i.heading_q4 = 1000
            i.rate_q4 = 7
            motion.step(i, 0, CAPS)
            assert motion._turn.kept_q4 == 1000
            assert motion._turn.held_at == (1000, 7)
            assert outputs(motion) == (600, out)
            assert motion._turn.followed == out
            against = LEFT_BIT if out > 0 else RIGHT_BIT
            motion.step(i, against, CAPS)
            assert outputs(motion) == (600, 0)


def test_without_a_heading_it_goes_forward_unheld_and_without_the_tilt_it_creeps():
    creep = 120 * 1000 // 556  # of the fastest profile
    for fault in range(len(codes.FAULTS)):
        motion, i = begun(codes.FORWARD, codes.CONTINUOUS)
        motion._turn.held = 70
        motion.step(i, 0, CAPS, 1 << fault)
        heading = (1 << fault) & codes.HEADING_FAULTS
        lost = heading and fault != codes.HEADING_JUMP
        assert outputs(motion) == (creep if lost else 600, 0 if heading else 70)


def test_without_the_tilt_it_creeps_backwards_and_in_steps_too():
    for verb, mode in (
        (codes.BACKWARD, codes.CONTINUOUS),
        (codes.BACKWARD, codes.STEP),
        (codes.FORWARD, codes.STEP),
        (codes.FORWARD, codes.TUNE),
        (codes.DRIVE, codes.CONTINUOUS),
    ):
        motion, i = begun(verb, mode)
        i.linear_permille = -1000
        i.pulse_ms = 1000
        for _ in range(400):
            motion.step(i, 0, CAPS, 1 << codes.HEADING_BUS)
            linear = abs(motion.linear_permille)
            assert linear <= 120 * 1000 // (556 if verb == codes.FORWARD else 472)
        assert linear > 200


def test_no_other_motion_holds_the_heading():
    for verb, mode in (
        (codes.BACKWARD, codes.STEP),
        (codes.BACKWARD, codes.CONTINUOUS),
        (codes.DRIVE, codes.CONTINUOUS),
        (codes.FORWARD, codes.TUNE),
    ):
        motion, i = begun(verb, mode, 100, 0)
        motion._turn.held = 70
        i.pulse_ms = 100
        motion.step(i, 0, CAPS)
        assert motion.linear_permille
        assert motion.turn_permille == 0


# -- a tuning pulse --------------------------------------------------------------------------------


def test_a_pulse_puts_out_what_it_says_for_as_long_as_it_says():
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
