# Stopping distance in one direction, and the highest output for a given clearance.
#
# One table per direction and assumption about the chair, made when settings change.
#
# A unit is 1 mm forward and backward, 1/16 degree in turns. All products stay within 31 bits for
# the settings' ranges: a speed is at most 2400 units/s, a time 1400 ms.
#
#   stop(v) = v * t + v * v / (2 * a) + margin     t: until it brakes, a: its braking
#   begin(v) = stop(v) + v * AHEAD_MS              slowing down begins here
#
# No setting makes the assumed chair slower than it was measured: a row of the settings and its
# default both count, and the worse of the two applies.

from array import array

from gazeboard.core import limits
from gazelink import codes
from gazelink.settings_table import PROFILES, TABLE, index_of, profile_row

LEVELS = 16  # outputs between creep and no limit
FULL_PERMILLE = 1000
_Q4_DEG_PER_RADIAN = 917
_FULL = ("forward_mm_s", "backward_mm_s", "left_q4_dps", "right_q4_dps")
_UNIT_Q4 = 16  # sixteenths in a degree


class Stopping:
    # direction: codes.DIR_*. trusted: the chair turns as the selected profile says, so it is that
    # one or one that turns alike; else it may be the fastest of all, with the weakest brake.

    def __init__(self, settings, direction, trusted):
        turns = direction >= codes.DIR_LEFT
        profiles = range(len(PROFILES))
        if trusted:
            profiles = [profile for profile in profiles if _turns_alike(settings, profile)]

        def rows(name):
            return [value for profile in profiles for value in _believed(settings, profile, name)]

        self.full = max(rows(_FULL[direction]))  # units/s at full deflection
        self.dead_ms = max(rows("dead_time_ms"))
        lag_ms = max(rows("lag_ms"))
        # The rows are measured in turns: going straight, a chair rolls on longer.
        self.tail_ms = lag_ms + lag_ms // 4
        if turns:
            self.brake = min(rows("brake_dps2")) * _UNIT_Q4  # units/s2
            self.margin = settings.stop_margin_q4_deg
            self.band = limits.BAND_Q4_DEG
            output = max(settings.turn_permille, settings.step_turn_permille)
        else:
            self.brake = min(rows("brake_mm_s2"))
            self.margin = settings.stop_margin_mm
            self.band = limits.BAND_MM
            output = settings.linear_permille
        self.two_brake = 2 * self.brake
        self.time_ms = max(settings.reaction_ms, self.dead_ms + lag_ms)
        self._turns = turns
        self.auto = self._permille(settings.auto_mm_s)  # most output of an auto motion
        self._make_table(settings, output, self._least(settings, direction, trusted))

    # The least output that moves the chair. 0: that might be faster than anything creeps. A turn
    # that is not trusted yet is tried with as much as may be: profile_check.py sees what comes.
    def _least(self, settings, direction, trusted):
        moving = _moving_permille(settings, direction)
        most = self._permille(limits.CREEP_MOST_MM_S)
        if moving <= most:
            return moving
        return most if self._turns and not trusted and most >= limits.TRYING_PERMILLE else 0

    # What runs further than `output`, the most the settings let out, limits nothing.
    def _make_table(self, settings, output, moving):
        last = FULL_PERMILLE
        if not settings.relay_fitted:
            last = max(self._permille(limits.NO_RELAY_MM_S), moving) if moving else 0
            output = min(output, last)
        least = min(output, max(self._permille(settings.creep_mm_s), moving))
        creep = least if moving else 0
        self.creep = self.speed(creep)
        outputs = [least + (output - least) * k // LEVELS for k in range(LEVELS + 1)]
        self.permille = [creep] + outputs[1:LEVELS] + [last]
        begin = [self.stop(self.creep)]
        for permille in outputs[1:]:
            v = self.speed(permille)
            begin.append(self.stop(v) + v * limits.SLOW_AHEAD_MS // 1000)
        self.begin = array("i", begin)

    # The output that makes at most this speed of the chair's outermost point.
    def _permille(self, mm_s):
        v = mm_s * _Q4_DEG_PER_RADIAN // limits.OUTERMOST_MM if self._turns else mm_s
        return min(FULL_PERMILLE, v * FULL_PERMILLE // self.full)

    # Units/s that an output makes at most, rounded up.
    def speed(self, permille):
        return (permille * self.full + FULL_PERMILLE - 1) // FULL_PERMILLE

    # Units from a decision to stop until the chair stands, margin included.
    def stop(self, speed):
        return speed * self.time_ms // 1000 + speed * speed // self.two_brake + self.margin

    # Milliseconds that takes.
    def stop_ms(self, speed):
        return self.time_ms + 1000 * speed // self.brake


# A row of a profile: as set, and as seen on the chair.
def _believed(settings, profile, name):
    row = profile_row(profile, name)
    return (getattr(settings, row), TABLE[index_of(row)][1])


# Whether a chair in `profile` may turn as the selected profile says, within what profile_check.py
# takes for agreement: up to a quarter off, and more where its deadband takes away what the selected
# one's does not.
def _turns_alike(settings, profile):
    telling = limits.TELLING_PERMILLE
    deadband = settings.of_profile("deadband_permille")
    believed = (telling - deadband) * FULL_PERMILLE // (FULL_PERMILLE - deadband)
    most = limits.DEADBAND_MOST_PERMILLE
    true = (telling - most) * FULL_PERMILLE // (FULL_PERMILLE - most)
    for name in ("left_q4_dps", "right_q4_dps"):
        rate = settings.of_profile(name)
        fastest = max(rate, rate * believed // true) * 5 // 4
        rates = _believed(settings, profile, name)
        if min(rates) <= fastest and max(rates) >= rate * 5 // 8:
            return True
    return profile == settings.profile


# The least output that moves the selected profile's chair: less is not slower, but nothing. In a
# turn it must break loose, too: a quarter more than that takes.
def _moving_permille(settings, direction):
    deadband = settings.of_profile("deadband_permille")
    moving = deadband + limits.CREEP_OVER_PERMILLE
    if direction >= codes.DIR_LEFT:
        breakaway = (FULL_PERMILLE - deadband) * settings.of_profile("breakaway_q4_dps")
        moving = max(
            moving, deadband + 5 * breakaway // (4 * settings.of_profile(_FULL[direction]))
        )
    return moving
