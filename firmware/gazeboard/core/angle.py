# Angles on the circle.

from gazeboard.core.limits import HEADING_TURN_Q4_DEG
from gazelink.native import micropython

_HALF_Q4 = HEADING_TURN_Q4_DEG // 2


@micropython.native
def wrapped(angle_q4):
    # The same angle in -180..180 degrees, in 1/16 degree.
    return (angle_q4 + _HALF_Q4) % HEADING_TURN_Q4_DEG - _HALF_Q4
