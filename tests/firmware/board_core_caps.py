# Motion's outputs under the settings' limits, the command's cap and what obstacles leave of them:
# the least of them counts, in each direction, for every verb and mode.

from gazeboard.core.motion import Motion
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazelink import codes
from gazesim.core_rig import Turn

MODES = (codes.STEP, codes.CONTINUOUS)
MOST = 400  # of the settings


class Left:
    # What the arcs leave.
    def __init__(self, linear_cap=1000, turn_cap=1000):
        self.linear_cap = linear_cap
        self.turn_cap = turn_cap


# The output of the third tick, of the axis that the verb moves.
def output(verb, mode, cap=1000, caps=(1000, 1000, 1000, 1000), arcs=None, asked=0):
    i = Inputs()
    i.verb = verb
    i.mode = mode
    i.edge = 1
    i.cap_permille = cap
    i.linear_permille = asked if verb == codes.DRIVE else 0
    settings = Settings()
    settings.linear_permille = settings.turn_permille = settings.step_turn_permille = MOST
    settings.step_forward_ms = 200
    settings.step_ramp_ms = 0
    turn = Turn()
    turn.out = {codes.LEFT: 1000, codes.RIGHT: -1000}.get(verb, 0)
    motion = Motion(settings, turn)
    for _ in range(3):
        motion.step(i, 0, caps, 0, arcs)
    if verb in (codes.LEFT, codes.RIGHT):
        assert motion.linear_permille == 0
        return motion.turn_permille
    assert motion.turn_permille == 0
    return motion.linear_permille


VERBS = (
    (codes.FORWARD, codes.DIR_FORWARD, 1, 0),
    (codes.BACKWARD, codes.DIR_BACKWARD, -1, 0),
    (codes.LEFT, codes.DIR_LEFT, 1, 0),
    (codes.RIGHT, codes.DIR_RIGHT, -1, 0),
    (codes.DRIVE, codes.DIR_FORWARD, 1, 1000),
    (codes.DRIVE, codes.DIR_BACKWARD, -1, -1000),
)


def of_each():
    for mode in MODES:
        for verb, direction, sign, asked in VERBS:
            yield verb, mode, direction, sign, asked


def test_no_output_exceeds_the_settings():
    for verb, mode, _, sign, asked in of_each():
        assert output(verb, mode, asked=asked) == sign * MOST, (verb, mode)


def test_the_cap_of_the_command_is_below_the_settings():
    for verb, mode, _, sign, asked in of_each():
        for cap in (0, 1, 150, MOST - 1, MOST, MOST + 1, 1000):
            wanted = sign * min(cap, MOST)
            assert output(verb, mode, cap, asked=asked) == wanted, (verb, mode, cap)


def test_obstacles_cap_their_own_direction_only():
    for verb, mode, direction, sign, asked in of_each():
        for cap in (0, 1, 150, MOST - 1, MOST, MOST + 1):
            caps = [1000] * 4
            caps[direction] = cap
            wanted = sign * min(cap, MOST)
            assert output(verb, mode, caps=caps, asked=asked) == wanted, (verb, mode, cap)
            others = [cap] * 4
            others[direction] = 1000
            assert output(verb, mode, caps=others, asked=asked) == sign * MOST, (verb, mode)


def test_arcs_cap_their_axis():
    for verb, mode, direction, sign, asked in of_each():
        turns = direction >= codes.DIR_LEFT
        for cap in (0, 1, 150, MOST - 1, MOST, MOST + 1):
            for own in (True, False):
                axis = turns == own
                arcs = Left(turn_cap=cap) if axis else Left(linear_cap=cap)
                wanted = min(cap, MOST) if own else MOST
                assert output(verb, mode, arcs=arcs, asked=asked) == sign * wanted, (verb, cap)


def test_the_lowest_of_all_caps_counts():
    for verb, mode, direction, sign, asked in of_each():
        for least in range(3):
            limits = [300, 300, 300]
            limits[least] = 77
            caps = [1000] * 4
            caps[direction] = limits[1]
            arcs = Left(limits[2], limits[2])
            assert output(verb, mode, limits[0], caps, arcs, asked) == sign * 77, (verb, least)
