# PD controller in integers: holds the heading while the chair drives straight on.
#
# Units: error in 1/16 degree, rate in 1/16 degree/s, output in permille of full deflection.
# Gains are sixteenths: kp_q4 permille/degree * 16, kd_q4 permille/(degree/s) * 16. All products
# stay within 31 bits for gains up to GAIN_MAX and errors up to half a turn (2880):
# 3200 * 2880 < 2**24.

from gazelink.native import micropython

GAIN_MAX = 3200
OUTPUT_MAX = 1000


@micropython.native
def scaled(product):
    # product / 256 towards zero, so that both directions are treated alike.
    return product >> 8 if product >= 0 else -(-product >> 8)


class PD:
    def __init__(self, kp_q4, kd_q4):
        for gain in (kp_q4, kd_q4):
            if not 0 <= gain <= GAIN_MAX:
                raise ValueError("gain %d is outside 0..%d" % (gain, GAIN_MAX))
        self.kp_q4 = kp_q4
        self.kd_q4 = kd_q4

    # rate_q4 is the measured rate of the controlled value (not of the error).
    @micropython.native
    def update(self, error_q4, rate_q4):
        out = scaled(self.kp_q4 * error_q4) - scaled(self.kd_q4 * rate_q4)
        if out > OUTPUT_MAX:
            return OUTPUT_MAX
        return out if out > -OUTPUT_MAX else -OUTPUT_MAX
