# Feedback controllers in integers: P, PI, PD and PID on one base, selected by their gains.
#
# Units: error in 1/16 degree, rate in 1/16 degree/s, output in permille of full deflection.
# Gains are sixteenths: kp_q4 permille/degree * 16, ki_q4 permille/(degree s) * 16, kd_q4
# permille/(degree/s) * 16. All products stay within 31 bits for gains up to GAIN_MAX and errors
# up to half a turn (2880): 3200 * 2880 < 2**24; the integral is clamped to OUTPUT_MAX.

from gazelink.native import micropython

GAIN_MAX = 3200
OUTPUT_MAX = 1000
_INTEGRAL_UNIT = 256 * 1000  # q4 * q4, milliseconds
_INTEGRAL_MAX = OUTPUT_MAX * _INTEGRAL_UNIT


@micropython.native
def scaled(product):
    # product / 256 towards zero, so that both directions are treated alike.
    return product >> 8 if product >= 0 else -(-product >> 8)


class FeedbackController:
    # update() returns the output for one sample; reset() forgets the past.

    def __init__(self, kp_q4, ki_q4, kd_q4):
        for gain in (kp_q4, ki_q4, kd_q4):
            if not 0 <= gain <= GAIN_MAX:
                raise ValueError("gain %d is outside 0..%d" % (gain, GAIN_MAX))
        self.kp_q4 = kp_q4
        self.ki_q4 = ki_q4
        self.kd_q4 = kd_q4
        self._integral = 0

    @micropython.native
    def reset(self):
        self._integral = 0

    # rate_q4 is the measured rate of the controlled value (not of the error), dt_ms 0..10.
    @micropython.native
    def update(self, error_q4, rate_q4, dt_ms):
        proportional = self.kp_q4 * error_q4
        damping = self.kd_q4 * rate_q4
        out = scaled(proportional) - scaled(damping)
        if self.ki_q4:
            integral = self._integral + self.ki_q4 * error_q4 * dt_ms
            integral = max(-_INTEGRAL_MAX, min(_INTEGRAL_MAX, integral))
            term = integral // _INTEGRAL_UNIT
            # Anti-windup: no further integration into a saturated output.
            if -OUTPUT_MAX < out + term < OUTPUT_MAX or (term > 0) != (error_q4 > 0):
                self._integral = integral
            out += self._integral // _INTEGRAL_UNIT
        if out > OUTPUT_MAX:
            return OUTPUT_MAX
        return out if out > -OUTPUT_MAX else -OUTPUT_MAX


class P(FeedbackController):
    def __init__(self, kp_q4):
        FeedbackController.__init__(self, kp_q4, 0, 0)


class PI(FeedbackController):
    def __init__(self, kp_q4, ki_q4):
        FeedbackController.__init__(self, kp_q4, ki_q4, 0)


class PD(FeedbackController):
    def __init__(self, kp_q4, kd_q4):
        FeedbackController.__init__(self, kp_q4, 0, kd_q4)


class PID(FeedbackController):
    pass
