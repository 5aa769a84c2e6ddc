# The turn controller: brings the heading to a setpoint and stops there, once and cleanly. Integers,
# no allocation.
#
# A move is full deflection, full counter-deflection, nothing. When to change over is told by the
# chair's model, which runs a dead time ahead, and by the stop plan; the feedback controller acts on
# what the heading seen deviates from the model's, and moves the changes accordingly. At rest, what
# is still missing is made good by at most two more moves, planned the same way.

from gazeboard.chair_model import ChairModel
from gazeboard.limits import HEADING_TURN_Q4_DEG
from gazeboard.pid import PD
from gazeboard.stop_plan import StopPlan
from gazelink.const import const
from gazelink.native import micropython

_HALF_Q4 = HEADING_TURN_Q4_DEG // 2
_HALF_TURN_Q16 = const(11796480)
_TURN_Q16 = const(23592960)

_GO = const(0)
_COUNTER = const(1)
_COAST = const(2)

_MOVES = const(3)  # the first and its corrections
_NEAR_Q4 = const(32)  # with nothing more to be done: 2 degrees beside is there all the same
_REST_Q4 = const(16)  # slower than 1 degree/s is rest
_SETTLE_MS = const(150)


@micropython.native
def wrapped(angle_q4):
    # The same angle in -180..180 degrees, in 1/16 degree.
    return (angle_q4 + _HALF_Q4) % HEADING_TURN_Q4_DEG - _HALF_Q4


class TurnController:
    # model: a ChairModel, stepped by whoever puts out. left, right: a StopPlan each. controller: a
    # FeedbackController, degrees of landing per degree of deviation. cutoff_q4: nearer than this
    # is there. limit_permille: full deflection.

    def __init__(self, model, left, right, controller, cutoff_q4, limit_permille):
        self.model = model
        self._left = left
        self._right = right
        self._controller = controller
        self._cutoff_q4 = cutoff_q4
        self._limit = limit_permille
        self._count = -1
        self._setpoint_q4 = 0
        self._offset_q16 = 0
        self._trim_q8 = 0
        self._phase = _COAST
        self._sign = 1
        self._plan = left
        self._moves = 0
        self._rest_ms = 0
        self.arrived = False
        self.missed = False  # at rest beside the setpoint, with no move left

    # One ms of what was put out, whatever the motion.
    @micropython.native
    def follow(self, turn_permille):
        self.model.step(turn_permille)

    @micropython.native
    def start(self, setpoint_q4, heading_q4):
        self._setpoint_q4 = setpoint_q4 % HEADING_TURN_Q4_DEG
        self._moves = 0
        self.arrived = False
        self.missed = False
        self._begin(heading_q4)

    @micropython.native
    def _begin(self, heading_q4):
        self._moves += 1
        self._rest_ms = 0
        self._offset_q16 = (heading_q4 << 12) - self.model.seen_angle()
        self._trim_q8 = 0
        self._controller.reset()
        self._phase = _GO
        self._sign = 1 if self._left_q8() >= 0 else -1
        self._plan = self._left if self._sign > 0 else self._right

    # One tick of 1 ms: the turn output in permille, left positive. count: of heading samples.
    @micropython.native
    def update(self, heading_q4, rate_q4, count):
        if count != self._count:
            self._count = count
            self._compare(heading_q4, rate_q4)
        if self._phase == _GO:
            if self._goes_on():
                return self._limit if self._sign > 0 else -self._limit
            self._phase = _COUNTER
        if self._phase == _COUNTER:
            if self._counters_on():
                return -self._limit if self._sign > 0 else self._limit
            self._phase = _COAST
        self._coast(heading_q4, rate_q4)
        return 0

    # How far the end will be beside the plan, from what is seen now.
    @micropython.native
    def _compare(self, heading_q4, rate_q4):
        model = self.model
        off_q4 = wrapped(((heading_q4 << 12) - model.seen_angle() - self._offset_q16) >> 12)
        rate_off_q4 = rate_q4 - (model.seen_rate() >> 6)
        self._trim_q8 = self._controller.update(off_q4, -rate_off_q4, 10) << 4

    # From where the model is to the setpoint, 1/256 degree.
    @micropython.native
    def _left_q8(self):
        to_q16 = (self._setpoint_q4 << 12) - self._offset_q16 - self.model.angle()
        to_q16 = (to_q16 + _HALF_TURN_Q16) % _TURN_Q16 - _HALF_TURN_Q16
        return (to_q16 >> 8) - self._trim_q8

    @micropython.native
    def _goes_on(self):
        model = self.model
        sign = self._sign
        ramp_q6 = sign * model.ramp_q6()
        left_q8 = sign * self._left_q8()
        if ramp_q6 < 0:
            return left_q8 > 0
        return left_q8 > self._plan.stop_q8(ramp_q6, sign * model.rate_q6())

    @micropython.native
    def _counters_on(self):
        model = self.model
        sign = self._sign
        ramp_q6 = sign * model.ramp_q6()
        if ramp_q6 > 0:
            return True
        return self._plan.end_rate_q6(-ramp_q6, sign * model.rate_q6()) > 0

    @micropython.native
    def _coast(self, heading_q4, rate_q4):
        model = self.model
        if not -_REST_Q4 <= rate_q4 <= _REST_Q4 or model.moves():
            self._rest_ms = 0
            return
        self._rest_ms += 1
        if self._rest_ms < _SETTLE_MS:
            return
        error_q4 = wrapped(self._setpoint_q4 - heading_q4)
        if -self._cutoff_q4 <= error_q4 <= self._cutoff_q4:
            self.arrived = True
        elif self._moves < _MOVES:
            self._begin(heading_q4)
        elif -_NEAR_Q4 <= error_q4 <= _NEAR_Q4:
            self.arrived = True
        else:
            self.missed = True


# The controller for the selected profile of `settings`.
def turn_controller(settings):
    s = settings
    of = s.of_profile
    left = of("left_q4_dps")
    right = of("right_q4_dps")
    dynamics = (of("accelerate_dps2"), of("brake_dps2"), of("lag_ms"))
    # A rate that is off stays so until the changed output arrives and passes the lag.
    horizon_ms = of("dead_time_ms") + of("lag_ms")
    return TurnController(
        ChairModel(s),
        StopPlan(left, right, *dynamics),
        StopPlan(right, left, *dynamics),
        PD(256, 256 * horizon_ms // 1000),
        s.turn_cutoff_q4_deg,
        s.step_turn_permille,
    )
