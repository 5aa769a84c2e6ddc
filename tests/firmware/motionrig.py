# A motion begun by one press, its turn controller scripted.

from gazeboard.core.motion import Motion
from gazeboard.core.shared import Inputs
from gazeboard.io.settings import Settings
from gazelink import codes
from gazesim.core_rig import Turn

TURNS = (codes.LEFT, codes.RIGHT)
CAPS = (1000, 1000, 1000, 1000)


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
