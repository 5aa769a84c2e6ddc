# The turn controller: brings the heading to a setpoint and stops there. Integers, no allocation.

from gazeboard.limits import HEADING_TURN_Q4_DEG
from gazelink.native import micropython

_HALF_Q4 = HEADING_TURN_Q4_DEG // 2


@micropython.native
def wrapped(angle_q4):
    # The same angle in -180..180 degrees, in 1/16 degree.
    return (angle_q4 + _HALF_Q4) % HEADING_TURN_Q4_DEG - _HALF_Q4


class TurnController:
    # controller: a FeedbackController. cutoff_q4: no output nearer to the setpoint than this.
    # offset_permille: what the chair needs to move at all, added outside the cut-off.
    # settle_ms: arrived after this long within the cut-off and slower than rest_q4 (1/16 degree/s).

    def __init__(self, controller, cutoff_q4, offset_permille, limit_permille, settle_ms, rest_q4):
        self._controller = controller
        self._cutoff_q4 = cutoff_q4
        self._offset = offset_permille
        self._limit = limit_permille
        self._settle_ms = settle_ms
        self._rest_q4 = rest_q4
        self._setpoint_q4 = 0
        self._settled_ms = 0
        self.arrived = False

    @micropython.native
    def start(self, setpoint_q4):
        self._setpoint_q4 = setpoint_q4 % HEADING_TURN_Q4_DEG
        self._settled_ms = 0
        self.arrived = False
        self._controller.reset()

    # One tick of 1 ms: the turn output in permille, left positive.
    @micropython.native
    def update(self, heading_q4, rate_q4):
        error_q4 = wrapped(self._setpoint_q4 - heading_q4)
        near = -self._cutoff_q4 <= error_q4 <= self._cutoff_q4
        if near and -self._rest_q4 <= rate_q4 <= self._rest_q4:
            self._settled_ms += 1
            self.arrived = self._settled_ms >= self._settle_ms
        else:
            self._settled_ms = 0
        out = self._controller.update(error_q4, rate_q4, 1)
        if near or out == 0:
            return 0
        out += self._offset if out > 0 else -self._offset
        return max(-self._limit, min(self._limit, out))
