# Model of how the chair turns in the selected speed profile.
#
# It has deadband, dead time, ramp, stiction and lag, and is stepped with the actual output.
# Integers, no allocation.
#
# Its state is the one the chair will have when the present output takes effect, one dead time from
# now; at() is the state that the newest heading sample shows. Rates are in 1/1024 degree/s (q10),
# the ramp in 1/65536 degree/s, angles in 1/65536 degree (q16) within half a turn.

import array

from gazelink.const import const
from gazelink.native import micropython, ptr32

# Indices of the state; stop_plan.py knows some of them.
_ASKED = const(0)  # the requested speed, q16
_RAMP = const(1)  # q16
_RATE = const(2)  # q10
_RATE_REST = const(3)
_ANGLE = const(4)  # q16
_ANGLE_REST = const(5)
_HEAD = const(6)
_OUT = const(7)  # the output that requested it, permille

# Then the numbers.
_DEADBAND = const(8)
_LEFT = const(9)  # speed per permille beyond the deadband, q16
_RIGHT = const(10)
_ACCELERATE = const(11)  # q16 a ms
_BRAKE = const(12)
_FOLLOW = const(13)  # share of the difference that the lag lets through in a ms, 1/65536
_BREAKAWAY = const(14)  # a ramp below this leaves a standing chair standing, q16
_DEAD_MS = const(15)
_PAST = const(16)  # then angle and rate of each ms, in a ring

_STILL = const(512)  # half a degree/s, q10
_PAST_MS = const(512)  # a power of two, above the longest dead time
_HALF_TURN = const(11796480)  # q16
_TURN = const(23592960)


class ChairModel:
    # settings: a Settings.

    def __init__(self, settings):
        of = settings.of_profile
        deadband = of("deadband_permille")
        self.dead_ms = of("dead_time_ms")
        self.lag_ms = of("lag_ms")
        numbers = [
            deadband,
            (of("left_q4_dps") << 12) // (1000 - deadband),
            (of("right_q4_dps") << 12) // (1000 - deadband),
            (of("accelerate_dps2") << 16) // 1000,
            (of("brake_dps2") << 16) // 1000,
            (2 << 16) // (2 * self.lag_ms + 1),  # 1 - exp(-1 / lag) within 0.03 %
            of("breakaway_q4_dps") << 12,
            self.dead_ms,
        ]
        self.state = array.array("i", [0] * _DEADBAND + numbers + [0] * (2 * _PAST_MS))

    # One ms of `permille`, left positive, -1000..1000. Returns the angle that is seen now, q16.
    @micropython.viper
    def step(self, permille: int) -> int:
        s = ptr32(self.state)
        if permille != s[_OUT]:
            s[_OUT] = permille
            asked = 0
            if permille > s[_DEADBAND]:
                asked = (permille - s[_DEADBAND]) * s[_LEFT]
            elif permille + s[_DEADBAND] < 0:
                asked = (permille + s[_DEADBAND]) * s[_RIGHT]
            s[_ASKED] = asked
        ramp = s[_RAMP]
        wanted = s[_ASKED]
        if wanted != ramp:
            # Faster: in the same sense and more; anything else brakes.
            change = s[_BRAKE]
            if wanted > ramp:
                if ramp >= 0:
                    change = s[_ACCELERATE]
                ramp += change
                if ramp > wanted:
                    ramp = wanted
            else:
                if ramp <= 0:
                    change = s[_ACCELERATE]
                ramp -= change
                if ramp < wanted:
                    ramp = wanted
            s[_RAMP] = ramp
        # At most 300 degrees/s apart: 307200 * 3277 < 2**30. What the shift drops is kept.
        before = s[_RATE]
        rest = ((ramp >> 6) - before) * s[_FOLLOW] + s[_RATE_REST]
        rate = before + (rest >> 16)
        s[_RATE_REST] = rest & 0xFFFF
        # It sticks where it stands, or turns round, below what would break it loose.
        if ramp < s[_BREAKAWAY] and ramp + s[_BREAKAWAY] > 0:
            if before == 0 or (before > 0 and rate < 0) or (before < 0 and rate > 0):
                rate = 0
                s[_RATE_REST] = 0
        # At a standstill the brakes hold it.
        if ramp == 0 and wanted == 0 and rate < _STILL and rate + _STILL > 0:
            rate = 0
        s[_RATE] = rate
        # 2**23 / 1000 per ms: 38400 * 8389 + 2**15 < 2**30.
        rest = (rate >> 2) * 8389 + s[_ANGLE_REST]
        angle = s[_ANGLE] + (rest >> 15)
        s[_ANGLE_REST] = rest & 0x7FFF
        if angle >= _HALF_TURN:
            angle -= _TURN
        elif angle + _HALF_TURN < 0:
            angle += _TURN
        s[_ANGLE] = angle
        head = (s[_HEAD] + 2) & (2 * _PAST_MS - 1)
        s[_HEAD] = head
        s[_PAST + head] = angle
        s[_PAST + head + 1] = rate
        return s[_PAST + ((head - 2 * s[_DEAD_MS]) & (2 * _PAST_MS - 1))]

    # Angle (q16) and rate (q10) that the newest heading sample shows.
    @micropython.viper
    def seen_angle(self) -> int:
        s = ptr32(self.state)
        return s[_PAST + ((s[_HEAD] - 2 * s[_DEAD_MS]) & (2 * _PAST_MS - 1))]

    @micropython.viper
    def seen_rate(self) -> int:
        s = ptr32(self.state)
        return s[_PAST + 1 + ((s[_HEAD] - 2 * s[_DEAD_MS]) & (2 * _PAST_MS - 1))]

    # No more motion is requested, and the chair's ramp is back at zero.
    @micropython.native
    def let_go(self):
        return self.state[_ASKED] == 0 and self.state[_RAMP] == 0

    @micropython.native
    def slower(self, rate_q10):
        return -rate_q10 < self.state[_RATE] < rate_q10

    # The gyro reports standstill, and no output is within the dead time.
    @micropython.viper
    def halt(self):
        s = ptr32(self.state)
        s[_RATE] = 0
        s[_RATE_REST] = 0
        angle = s[_ANGLE]
        k = 0
        while k < 2 * _PAST_MS:
            s[_PAST + k] = angle
            s[_PAST + k + 1] = 0
            k += 2

    # It turns as fast as requested, within an eighth: ramp and lag are over.
    @micropython.viper
    def steady(self) -> bool:
        s = ptr32(self.state)
        asked_q10 = s[_ASKED] >> 6
        rate_q10 = s[_RATE]
        if asked_q10 < 0:
            asked_q10 = 0 - asked_q10
            rate_q10 = 0 - rate_q10
        off_q10 = asked_q10 - rate_q10
        if off_q10 < 0:
            off_q10 = 0 - off_q10
        return asked_q10 != 0 and off_q10 <= asked_q10 >> 3
