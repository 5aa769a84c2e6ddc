# Motion's outputs when both axes are asked for, and which setting is the most of a turn: against
# the same rules in plain numbers.

from gazeboard.core.motion import Motion
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazelink import codes
from gazesim.core_rig import Turn

LINEAR, TURN, STEP_TURN, HOLD = 600, 500, 700, 150
AXES = (-1000, -601, -333, -2, -1, 1, 2, 77, 500, 1000)
CAPS = (0, 1, 2, 77, 332, 499, 500, 501, 599, 600, 601, 1000)


class Dice:
    def __init__(self, seed):
        self.state = seed

    def among(self, values):
        self.state = (self.state * 1103515245 + 12345) & 0x7FFFFFFF
        return values[(self.state >> 12) % len(values)]


class Left:
    # What the arcs leave.
    def __init__(self, linear_cap, turn_cap):
        self.linear_cap = linear_cap
        self.turn_cap = turn_cap


def motion_of(verb, mode, linear=0, turn=0, cap=1000):
    settings = Settings()
    settings.linear_permille = LINEAR
    settings.turn_permille = TURN
    settings.step_turn_permille = STEP_TURN
    settings.hold_permille = HOLD
    i = Inputs()
    i.verb = verb
    i.mode = mode
    i.edge = 1
    i.linear_permille = linear
    i.turn_permille = turn
    i.cap_permille = cap
    i.pulse_ms = 100
    return Motion(settings, Turn()), i


def within(value, most):
    return max(-most, min(most, value))


# A part of a number, towards 0.
def part(value, of, whole):
    size = abs(value) * of // whole
    return size if value > 0 else -size


def curve(linear, turn, cap, caps, arcs):
    linear = within(linear, min(cap, LINEAR))
    turn = within(turn, min(cap, TURN))
    along = caps[codes.DIR_FORWARD if linear > 0 else codes.DIR_BACKWARD]
    aside = caps[codes.DIR_LEFT if turn > 0 else codes.DIR_RIGHT]
    if arcs is not None:
        along = min(along, arcs.linear_cap)
        aside = min(aside, arcs.turn_cap)
    if abs(linear) > along:
        linear, turn = within(linear, along), part(turn, along, abs(linear))
    if abs(turn) > aside:
        linear, turn = part(linear, aside, abs(turn)), within(turn, aside)
    return linear, turn


def test_a_curve_that_obstacles_slow_down_stays_a_curve():
    dice = Dice(1)
    motion, i = motion_of(codes.DRIVE, codes.CONTINUOUS)
    for number in range(3000):
        linear, turn = dice.among(AXES), dice.among(AXES)
        i.linear_permille, i.turn_permille = linear, turn
        i.cap_permille = cap = dice.among(CAPS) if number & 1 else 1000
        caps = [dice.among(CAPS) for _ in range(4)]
        arcs = Left(dice.among(CAPS), dice.among(CAPS)) if number & 2 else None
        motion.step(i, 0, caps, 0, arcs)
        expected = curve(linear, turn, cap, caps, arcs)
        assert (motion.linear_permille, motion.turn_permille) == expected, (linear, turn, caps)


def test_one_axis_of_a_stick_is_limited_in_its_own_direction():
    for asked in (-1000, -2, -1, 1, 2, 1000):
        for most in (0, 1, 300):
            for direction in range(4):
                caps = [1000] * 4
                caps[direction] = most
                for turns in (False, True):
                    motion, i = motion_of(codes.DRIVE, codes.CONTINUOUS)
                    if turns:
                        i.turn_permille = asked
                    else:
                        i.linear_permille = asked
                    motion.step(i, 0, caps)
                    own = (2 if turns else 0) + (asked < 0)
                    limit = TURN if turns else LINEAR
                    expected = within(asked, min(limit, most) if own == direction else limit)
                    got = (motion.linear_permille, motion.turn_permille)
                    assert got == ((0, expected) if turns else (expected, 0))


def test_each_kind_of_turn_has_its_own_limit():
    for verb, mode, most in (
        (codes.LEFT, codes.STEP, STEP_TURN),
        (codes.LEFT, codes.TUNE, STEP_TURN),
        (codes.LEFT, codes.CONTINUOUS, TURN),
        (codes.DRIVE, codes.CONTINUOUS, TURN),
        (codes.DRIVE, codes.STEP, TURN),
        (codes.FORWARD, codes.STEP, HOLD),
        (codes.FORWARD, codes.CONTINUOUS, HOLD),
    ):
        for sign in (1, -1):
            if verb == codes.LEFT and mode != codes.STEP and sign < 0:
                continue
            for step_turn in (STEP_TURN, 300):
                motion, i = motion_of(verb, mode, 0, sign * 1000)
                motion._settings.step_turn_permille = step_turn
                motion._turn.out = motion._turn.held = sign * 1000
                motion.step(i, 0, [1000] * 4)
                wanted = step_turn if most == STEP_TURN else most
                assert motion.turn_permille == sign * wanted, (verb, mode)


def test_a_continuous_turn_is_limited_to_either_side():
    for held, direction in ((1, codes.DIR_LEFT), (-1, codes.DIR_RIGHT), (70, 2), (-70, 3)):
        for other in (2, 3):
            motion, i = motion_of(codes.FORWARD, codes.CONTINUOUS)
            motion._turn.held = held
            caps = [1000] * 4
            caps[other] = 0
            motion.step(i, 0, caps)
            assert motion.turn_permille == (0 if other == direction else held)


def test_a_lost_heading_is_no_longer_kept():
    motion, i = motion_of(codes.FORWARD, codes.CONTINUOUS)
    motion._turn.held = 70
    motion.step(i, 0, [1000] * 4)
    assert motion.turn_permille == 70
    motion.step(i, 0, [1000] * 4, 1 << codes.HEADING_JUMP)
    assert (motion.linear_permille, motion.turn_permille) == (LINEAR, 0)


def test_an_axis_that_the_next_press_does_not_ask_for_is_neutral():
    motion, i = motion_of(codes.DRIVE, codes.CONTINUOUS, 300, 200)
    motion.step(i, 0, [1000] * 4)
    i.edge = 2
    i.verb = codes.BACKWARD
    motion.step(i, 0, [1000] * 4)
    assert (motion.linear_permille, motion.turn_permille) == (-LINEAR, 0)


def test_only_going_forward_keeps_a_heading():
    for verb in range(codes.FORWARD, codes.DRIVE + 1):
        motion, i = motion_of(verb, codes.CONTINUOUS, 100, 100)
        i.heading_q4 = 1000
        motion.step(i, 0, [1000] * 4)
        assert motion._turn.kept_q4 == (1000 if verb == codes.FORWARD else None)


def test_the_first_step_turn_counts_from_the_heading():
    motion, i = motion_of(codes.LEFT, codes.STEP)
    i.heading_q4 = 20
    motion.step(i, 0, [1000] * 4)
    assert motion._turn.setpoint_q4 == 20 + motion._settings.step_turn_q4_deg


def test_without_the_tilt_it_creeps_as_the_fastest_profile_would():
    for profile in range(5):
        settings = Settings()
        settings.profile = profile
        for verb, fastest, sign in ((codes.FORWARD, 556, 1), (codes.BACKWARD, 472, -1)):
            _, i = motion_of(verb, codes.CONTINUOUS)
            motion = Motion(settings, Turn())
            motion.step(i, 0, [1000] * 4, 1 << codes.HEADING_BUS)
            assert motion.linear_permille == sign * (120 * 1000 // fastest), profile
