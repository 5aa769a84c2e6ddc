# Motion to the tick: outputs of every verb and mode, limits, no motion into a blocked turn.

from gazelink import codes
from motionrig import CAPS, TURNS, begun, outputs

ALL = (codes.FORWARD, codes.BACKWARD, codes.LEFT, codes.RIGHT, codes.DRIVE)
LEFT_BIT = 1 << codes.DIR_LEFT
RIGHT_BIT = 1 << codes.DIR_RIGHT


def test_it_starts_at_rest():
    motion, _ = begun(codes.FORWARD, codes.STEP)
    assert outputs(motion) == (0, 0)
    assert motion.state == codes.STOPPED
    assert not motion.ended
    assert motion.end_reason == codes.NO_REASON


def test_every_verb_has_its_output_and_state():
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


def test_a_continuous_motion_has_no_end_of_its_own():
    for verb in ALL:
        motion, i = begun(verb, codes.CONTINUOUS, 100, 100)
        for _ in range(1000):
            motion.step(i, 0, CAPS)
            assert outputs(motion) != (0, 0)
            assert not motion.ended


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


def test_no_turn_into_a_blocked_side_by_the_smallest_output():
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


def test_the_turn_controller_follows_what_is_put_out():
    motion, i = begun(codes.LEFT, codes.STEP)
    motion._turn.out = 9999
    motion.step(i, 0, CAPS)
    assert motion._turn.followed == 1000
    motion.step(i, LEFT_BIT, CAPS)
    assert motion._turn.followed == 0
    motion.step(i, 0, CAPS)
    motion.stop()
    assert motion._turn.followed == 0


def test_a_continuous_motion_has_its_output_at_once():
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


def test_holding_is_limited_before_the_chair_moves_too():
    for held, out in ((9999, 150), (-9999, -150)):
        motion, i = begun(codes.FORWARD, codes.STEP)
        motion._settings.step_ramp_ms = 1000
        motion._turn.held = held
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (0, out)


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


# A drive with the stick straight ahead, its heading held: 1000.
def driven(linear=300):
    motion, i = begun(codes.DRIVE, codes.CONTINUOUS, linear, 0)
    motion._turn.held = 70
    i.heading_q4 = 1000
    motion.step(i, 0, CAPS)
    assert outputs(motion) == (linear, 0)
    i.heading_q4 = 1001
    motion.step(i, 0, CAPS)
    assert outputs(motion) == (linear, 70)
    assert motion._turn.kept_q4 == 1000
    assert motion._turn.held_at == (1001, i.rate_q4)
    return motion, i


def test_a_stick_straight_ahead_keeps_the_heading_once_the_chair_hardly_turns():
    motion, i = begun(codes.DRIVE, codes.CONTINUOUS, 300, 0)
    motion._turn.held = 70
    for rate_q4 in (161, 160, -160, -161):
        i.rate_q4 = rate_q4
        for _ in range(2):
            motion.step(i, 0, CAPS)
            assert outputs(motion) == (300, 0)
            assert motion._turn.kept_q4 is None
    for rate_q4 in (159, -159):
        motion, i = begun(codes.DRIVE, codes.CONTINUOUS, 1, 0)
        motion._turn.held = 70
        i.rate_q4 = rate_q4
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (1, 0)
        i.rate_q4 = 900  # held now, however fast somebody turns it
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (1, 70)


def test_what_holds_a_straight_drive_is_limited_as_going_forward_is():
    for held, out in ((9999, 150), (-9999, -150)):
        motion, i = driven()
        motion._turn.held = held
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (300, out)
        assert motion._turn.followed == out
        i.cap_permille = 40
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (40, 40 if out > 0 else -40)
        i.cap_permille = 1000
        motion.step(i, LEFT_BIT if out > 0 else RIGHT_BIT, CAPS)
        assert outputs(motion) == (300, 0)
        for fault in range(len(codes.FAULTS)):
            heading = (1 << fault) & codes.HEADING_FAULTS
            motion.step(i, 0, CAPS, 1 << fault)
            assert motion.turn_permille == (0 if heading else out)


def test_a_drive_that_turned_or_went_back_keeps_the_heading_it_has_then():
    for linear, turn in ((300, 1), (300, -1), (0, 0), (-1, 0), (0, 5)):
        motion, i = driven()
        i.linear_permille = linear
        i.turn_permille = turn
        i.heading_q4 = 1100
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (linear, turn)
        i.linear_permille = 300
        i.turn_permille = 0
        i.heading_q4 = 1200
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (300, 0)
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (300, 70)
        assert motion._turn.kept_q4 == 1200


def test_a_new_drive_keeps_its_own_heading():
    for stops in (False, True):
        motion, i = driven()
        if stops:
            motion.stop()
        else:
            i.edge = 2
        i.heading_q4 = 1300
        motion.step(i, 0, CAPS)
        assert outputs(motion) == (300, 0)
        assert motion._turn.kept_q4 == 1300


def test_a_heading_that_was_lost_is_held_as_it_is_when_it_comes_back():
    for verb in (codes.FORWARD, codes.DRIVE):
        for fault in range(len(codes.FAULTS)):
            if (1 << fault) & codes.HEADING_FAULTS == 0:
                continue
            for pressed_before in (True, False):
                motion, i = begun(verb, codes.CONTINUOUS, 300, 0)
                motion._turn.held = 70
                i.heading_q4 = 1000
                if pressed_before:
                    motion.step(i, 0, CAPS)
                    motion.step(i, 0, CAPS)
                    assert motion._turn.kept_q4 == 1000
                i.heading_q4 = 1300
                for _ in range(3):
                    motion.step(i, 0, CAPS, 1 << fault)
                    assert motion.turn_permille == 0
                i.heading_q4 = 1400
                motion.step(i, 0, CAPS, 1 << fault)
                assert motion._turn.kept_q4 == 1400
                i.heading_q4 = 1401
                motion.step(i, 0, CAPS)
                assert motion._turn.kept_q4 == 1400
                assert motion.turn_permille == 70


def test_no_other_motion_holds_the_heading():
    for verb, mode, linear, turn in (
        (codes.BACKWARD, codes.STEP, 100, 0),
        (codes.BACKWARD, codes.CONTINUOUS, 100, 0),
        (codes.DRIVE, codes.CONTINUOUS, -100, 0),
        (codes.DRIVE, codes.CONTINUOUS, 0, 0),
        (codes.DRIVE, codes.CONTINUOUS, 100, 50),
        (codes.FORWARD, codes.TUNE, 100, 0),
    ):
        motion, i = begun(verb, mode, linear, turn)
        motion._turn.held = 70
        i.pulse_ms = 100
        for _ in range(3):
            motion.step(i, 0, CAPS)
            assert motion.linear_permille or not linear
            assert motion.turn_permille == turn
