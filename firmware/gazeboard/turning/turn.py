# Turn controller: brings the heading to a setpoint and stops there.
#
# Integers, no allocation. A move is full deflection, full counter-deflection, neutral. The chair's
# model, which runs one dead time ahead, and the stop plan determine when to switch; the feedback
# controller acts on the deviation of the measured heading from the model's, and shifts the
# switches. At rest, a few more moves, planned in the same manner (small_moves.py), remove the
# remaining error, including the floor's effect (slope.py).

from gazeboard.core.angle import wrapped
from gazeboard.core.limits import HEADING_TURN_Q4_DEG
from gazeboard.turning.casters import Casters
from gazeboard.turning.chair_model import ChairModel
from gazeboard.turning.pid import PD
from gazeboard.turning.slope import Slope
from gazeboard.turning.small_moves import SmallMoves
from gazeboard.turning.stop_plan import StopPlan
from gazelink.const import const
from gazelink.native import micropython
from gazelink.settings_table import NO_CASTERS_Q4_DEG

_TURN_Q16 = HEADING_TURN_Q4_DEG << 12
_HALF_Q16 = _TURN_Q16 // 2

_GO = const(0)
_COUNTER = const(1)
_COAST = const(2)
_START = const(3)

_MOVES = const(4)  # the first and its corrections
_MOVES_ALL = const(9)  # with those from rest
_RETURNS = const(2)  # how often a tuned chair's pushes may change sides after the first counter
_ENOUGH = const(5)  # after so many, what is left of the sensor's error is borne
_HOLD_ON = const(16)  # permille: half a degree with the usual gain
_HOLD_OFF = const(6)
_GENTLE_Q8 = const(800)  # a correction by less than 3 degrees runs out without counter-deflection
_NEAR_Q8 = const(512)  # with no move left, within 2 degrees counts as arrived
_SHORT_Q8 = const(64)  # a quarter degree short is better than a long coast
_STILL_Q8 = const(64)
_DOUBT_Q10 = const(8192)  # 8 degrees/s: below it the model counts, above it the measurement
_GAIN_MIN_Q8 = const(64)
_GAIN_MAX_Q8 = const(512)
_STALLED_MS = const(800)  # at rest this long while it should turn, something blocks the chair
_REST_Q4 = const(16)  # slower than 1 degree/s is rest
_SETTLE_MS = const(100)
_SURE_MS = const(400)  # near the cut-off's edge a floor may still carry it out
_SAMPLE_MS = const(10)
_STANDS_Q4 = const(8)  # measured slower than half a degree/s, a released chair stands
_STANDS = const(3)  # samples
_CREEPS_Q10 = const(1536)  # 1.5 degrees/s: a model so slow may be of a chair that stands
_ROLLS_OUT_Q10 = const(2048)
_SLOW_Q4 = const(48)  # 3 degrees/s: a small correction waits for the rest
_LEAST_Q8 = const(128)
_HALF_STEP_Q8 = const(8)  # of the heading sensor


class TurnController:
    # model: a ChairModel, stepped by the code that sets the output. left, right: a StopPlan each.
    # hold: the FeedbackController that keeps a heading, permille; deadband: the least output with
    # an effect. cutoff_q4: nearer than this has arrived. limit_permille: full deflection.

    def __init__(
        self, model, casters, left, right, hold, deadband, cutoff_q4, limit_permille, tuned
    ):
        self.model = model
        self._casters = casters
        self._slope = Slope(model)
        # One ms of output, whatever the motion: follow(turn_permille). Casters may add nothing.
        self.follow = self._follow if casters.any else model.step
        # What each tick uses, found at once; None for casters that add nothing.
        self._followed = (model.step, casters.advance)
        self._looked_at = (model.state, casters if casters.any else None, self._slope)
        self._small = SmallMoves()
        self._left = left
        self._right = right
        self._hold_update = hold.update
        self._deadband = deadband
        self._holds = False
        self._held_q4 = -1  # for which heading and rate `_held` is
        self._held_rate_q4 = 0
        self._held = 0
        self._cutoff_q8 = cutoff_q4 << 4
        self._there_q8 = self._cutoff_q8
        self._limit = limit_permille
        self._tuned = tuned
        self._way_q8 = 0
        self._pushed = 1
        self._left_q8 = 0
        self._seen_q16 = 0
        self._before_q16 = 0
        self._beside_q8 = 0
        self._gain_q8 = 256
        self._faster_q8 = 0
        self._sign = 1
        self._plan = left
        self._gentle = False
        self._rest_ms = 0
        self._from_q16 = 0
        self.start(0, -1)
        self._forget()
        self._phase = _COAST  # no turn yet

    @micropython.native
    def _follow(self, turn_permille):
        step, advance = self._followed
        advance(step(turn_permille))

    # count: of heading samples. The turn begins some ms later, so that no tick has too much to do.
    @micropython.native
    def start(self, setpoint_q4, count):
        self._setpoint_q4 = setpoint_q4 % HEADING_TURN_Q4_DEG
        self.arrived = False
        self.missed = False  # at rest off the setpoint with no move left, or blocked by something
        self._time_is_up = False
        self._phase = _START
        self._fresh = True
        self._count = count
        self._out = 0
        self._looked = False
        self._to_do = 0
        self._stalled_ms = 0
        self._slope.start()

    # What else the turn before has left: in the tick after the first look, which has less to do.
    @micropython.native
    def _forget(self):
        self._fresh = False
        self._moves = 0
        self._stands = 0
        self._idle_q16 = 0
        self._returns = 0  # how often its pushes changed sides
        self._small.start()

    # Its time is nearly over: no more corrections, they would be cut short.
    @micropython.native
    def settle(self):
        self._time_is_up = True

    @micropython.native
    def _begin(self, left_q8):
        sign = 1 if left_q8 >= 0 else -1
        if self._moves == 0:
            self._pushed = -sign  # by the coming counter-deflection
        elif sign != self._pushed:
            self._pushed = sign
            self._returns += 1
        self._moves += 1
        self._phase = _GO
        self._sign = sign
        self._plan = self._left if left_q8 >= 0 else self._right
        self._out = self._limit * self._sign
        self._gentle = self._moves > 1 and -_GENTLE_Q8 < left_q8 < _GENTLE_Q8
        from_rest = self._rest_ms >= _SETTLE_MS
        self._faster_q8 = 0
        self._small.begin(left_q8, sign, self._gentle and from_rest)
        self._rest_ms = 0

    # From now on hold() keeps this heading.
    @micropython.native
    def keep(self, heading_q4):
        self._setpoint_q4 = heading_q4
        self._holds = False
        self._held_q4 = -1

    # Going straight on: the turn output in permille that brings the heading back. Nothing for less
    # _HOLD_ON permille, so that the deadband is not crossed to and fro. Worked out once a sample.
    @micropython.native
    def hold(self, heading_q4, rate_q4):
        if heading_q4 == self._held_q4 and rate_q4 == self._held_rate_q4:
            return self._held
        self._held_q4 = heading_q4
        self._held_rate_q4 = rate_q4
        out = self._hold_update(wrapped(self._setpoint_q4 - heading_q4), rate_q4, 1)
        size = abs(out)
        if size < (_HOLD_OFF if self._holds else _HOLD_ON):
            self._holds = False
            self._held = 0
        else:
            self._holds = True
            self._held = out + self._deadband if out > 0 else out - self._deadband
        return self._held

    # One tick of 1 ms: the turn output in permille, left positive. count: of heading samples.
    @micropython.native
    def update(self, heading_q4, rate_q4, count):
        if count != self._count:
            # Its work fills this tick and three more; its result is used after them.
            self._count = count
            self._look(heading_q4, rate_q4)
            self._to_do = 1 if self._phase == _START else 3  # nothing to learn from yet
            return self._out
        if self._to_do:
            self._to_do -= 1
            if self._to_do == 2:
                self._watch_rest(rate_q4)
            elif self._to_do:
                self._learn_slope()
            else:
                if self._fresh:
                    self._forget()
                plan = self._plan
                way_q8 = plan.ahead_q8(self.model.state, self._seen_q16, self._sign, False)
                self._slope.look_ahead(way_q8)
                # At full speed another rate is another full speed, whose ramp back goes by its
                # square: as much again as the gain makes of it.
                self._faster_q8 = 0
                if self.model.steady():
                    self._faster_q8 = plan.brakes_q8 * (self._gain_q8 - 256) >> 8
                self._looked = True
            return self._out
        phase = self._phase
        if phase == _START:
            if self._looked:
                self._casters.watch(self._beside_q8)
                self._from_q16 = self._seen_q16
                # The sensor's own error: half a step, and 0.4 % of the turn.
                error_q8 = _HALF_STEP_Q8 + (abs(self._left_q8) >> 8)
                self._there_q8 = max(_LEAST_Q8, self._cutoff_q8 - error_q8)
                self._begin(self._left_q8)
            else:
                self._count = -1  # the first tick has enough to do: look in the next
        elif phase == _COAST:
            if not self._looked:
                return 0
            self._looked = False
            self._coast(rate_q4)
        elif phase == _GO:
            aim_q8 = self._left_q8 * self._sign
            if self._gentle:
                aim_q8 = self._small.aim_q8(aim_q8)
                if self._small.ends(aim_q8 <= self._turns_q8(False)):
                    self._phase = _COAST
                    self._out = 0
            elif aim_q8 <= self._turns_q8(True) + self._faster_q8:
                self._phase = _COUNTER
                self._out = -self._out
        else:
            more = self._plan.counters(self.model.state, self._sign)
            if more == 0 or (
                more == 1 and self._left_q8 * self._sign >= self._turns_q8(False) + _SHORT_Q8
            ):
                self._phase = _COAST
                self._out = 0
        return self._out

    # A new heading sample: how far it is from there, and how the chair turns compared to the model.
    @micropython.native
    def _look(self, heading_q4, rate_q4):
        model = self.model
        self._left_q8 = wrapped(self._setpoint_q4 - heading_q4) << 4
        self._before_q16 = self._seen_q16
        self._seen_q16 = model.seen_angle()
        rate_q10 = model.seen_rate()
        self._beside_q8 = wrapped(heading_q4 - (self._seen_q16 >> 12)) << 4
        if self._casters.any:
            self._casters.advance(self._seen_q16)
            deg_q8 = 256 if rate_q10 >= 0 else -256
            rate_q10 = rate_q10 * (256 + self._casters.swing_q8(deg_q8) * deg_q8 // 256) >> 8
        of_wheels_q4 = rate_q4 - (self._slope.drift_q8 >> 4)
        if rate_q10 < 0:
            rate_q10 = -rate_q10
            of_wheels_q4 = -of_wheels_q4
        gain_q8 = (((of_wheels_q4 << 6) + _DOUBT_Q10) << 8) // (rate_q10 + _DOUBT_Q10)
        if rate_q10 > _DOUBT_Q10 and -_REST_Q4 <= rate_q4 <= _REST_Q4:
            self._stalled_ms += _SAMPLE_MS
            self.missed = self._stalled_ms >= _STALLED_MS
        else:
            self._stalled_ms = 0
        self._gain_q8 = max(_GAIN_MIN_Q8, min(_GAIN_MAX_Q8, gain_q8))

    # Ignore model rotation while the gyro reports standstill: neither the floor nor the casters
    # caused it. A released chair that stands for longer than the dead time stays.
    @micropython.native
    def _watch_rest(self, rate_q4):
        model = self.model
        seen_q16 = self._seen_q16
        creeps = -_CREEPS_Q10 < model.seen_rate() < _CREEPS_Q10
        if self._out or not model.let_go() or not -_STANDS_Q4 <= rate_q4 <= _STANDS_Q4:
            self._stands = 0
        else:
            self._stands += 1
            if (
                self._phase == _COAST
                and (self._stands - _STANDS) * _SAMPLE_MS >= model.dead_ms
                and model.slower(_ROLLS_OUT_Q10)
            ):
                model.halt()
                self._seen_q16 = model.seen_angle()
                self._beside_q8 -= wrapped((self._seen_q16 - seen_q16) >> 12) << 4
                creeps = True
        if self._moves and creeps and -_REST_Q4 <= rate_q4 <= _REST_Q4:
            # To the last bit: it creeps by less than a sixteenth of a degree a sample.
            by_q16 = self._seen_q16 - self._before_q16
            if by_q16 > _HALF_Q16:
                by_q16 -= _TURN_Q16
            elif by_q16 < -_HALF_Q16:
                by_q16 += _TURN_Q16
            self._idle_q16 += by_q16
            self._from_q16 += by_q16
            self._casters.skip(model.seen_angle())
        else:
            self._casters.mark()

    @micropython.native
    def _learn_slope(self):
        if self._moves == 0:
            return
        rest_q8 = self._casters.learn(self._beside_q8 + (self._idle_q16 >> 8))
        way_q4 = wrapped((self._seen_q16 - self._from_q16) >> 12)
        self._slope.learn(rest_q8, way_q4, self.model.seen_rate())

    # How far the chair still turns to its side from the newest sample on, 1/256 degree, if the turn
    # is ended now: by counter-deflection, or released.
    @micropython.native
    def _turns_q8(self, counters):
        side = self._sign
        state, casters, slope = self._looked_at
        way_q8 = self._plan.ahead_q8(state, self._seen_q16, side, counters)
        self._way_q8 = way_q8
        if casters is not None:
            way_q8 += side * casters.swing_q8(side * way_q8)
        slides_q8 = slope.slides_braked_q8 if counters else slope.slides_q8
        return (way_q8 * self._gain_q8 >> 8) + side * slides_q8

    # On to the same side always, and as the first counter-deflection went. Back only when tuned, a
    # few times or when it is far off: an untuned chair comes back once and does not swing.
    @micropython.native
    def _may_go(self, left_q8):
        if self._time_is_up:
            return False
        if left_q8 > 0 or self._pushed != self._sign:
            return True
        if not self._tuned:
            return False
        return self._returns < _RETURNS or left_q8 < -_NEAR_Q8

    # Neutral output, a new sample: has it arrived, or is another move needed? A large one at once;
    # a small one from rest, when both the model and the sensor report it.
    @micropython.native
    def _coast(self, rate_q4):
        left_q8 = self._left_q8 * self._sign
        error_q8 = left_q8 - self._turns_q8(False)
        way_q8 = self._way_q8
        still = -_STILL_Q8 <= way_q8 <= _STILL_Q8
        slow = -_SLOW_Q4 < rate_q4 < _SLOW_Q4
        small = -_GENTLE_Q8 < error_q8 < _GENTLE_Q8
        if small and slow and not still:
            self._rest_ms = 0
            return
        doubt_q8 = self._there_q8 + (abs(way_q8) >> 2)
        if (
            not (small and still)
            and not -doubt_q8 <= error_q8 <= doubt_q8
            and self._moves < _MOVES
            and self._may_go(error_q8)
        ):
            self._begin(self._sign * error_q8)
            return
        if not still or not -_REST_Q4 <= rate_q4 <= _REST_Q4:
            self._rest_ms = 0
            return
        self._rest_ms += _SAMPLE_MS
        if self._rest_ms < _SETTLE_MS:
            return
        if self._moves >= _ENOUGH:
            self._there_q8 = self._cutoff_q8  # sufficient, to avoid swinging
        if (
            not -self._there_q8 <= left_q8 <= self._there_q8
            and self._moves < _MOVES_ALL
            and self._may_go(left_q8)
        ):
            self._begin(self._sign * left_q8)
        elif self._rest_ms >= _SURE_MS or abs(left_q8) <= self._there_q8 >> 1:
            self.arrived = -_NEAR_Q8 <= left_q8 <= _NEAR_Q8
            self.missed = not self.arrived


# The controller for the selected profile of `settings`.
def turn_controller(settings):
    s = settings
    of = s.of_profile
    left = of("left_q4_dps")
    right = of("right_q4_dps")
    dynamics = (of("accelerate_dps2"), of("brake_dps2"), of("lag_ms"))
    return TurnController(
        ChairModel(s),
        Casters(of("caster_q4_deg") - NO_CASTERS_Q4_DEG, of("caster_way_q4_deg")),
        StopPlan(left, right, *dynamics),
        StopPlan(right, left, *dynamics),
        PD(s.hold_kp_q4, s.hold_kd_q4),
        of("deadband_permille"),
        s.turn_cutoff_q4_deg,
        s.step_turn_permille,
        of("tuned"),
    )
