# The chair's tilt from the heading sensor: beyond the limit, level, or not known (P16). Pure.
#
# A sensor that cannot be read leaves the tilt unknown. Forward then stays possible (P7), at creep
# speed and for a short time only, and only from ground that was last measured as level: to
# leave a doorway, not to drive on.

from gazeboard.core import limits
from gazelink.const import const

_HYSTERESIS_Q4_DEG = const(48)
_BEYOND_MS = const(40)  # a jolt is no slope; nor is one sample, whatever came before it
_SAMPLE_MS = const(10)
_CLEAR_MS = const(300)  # within the limit again: longer than a sensor's reset stays unseen
_LEVEL_MS = const(300)
_LEVEL_ENOUGH_MS = const(200)
_SPIKE_MS = const(100)  # a single spike leaves level ground level, two do not


class Tilt:
    def __init__(self, limit_q4_deg):
        self.limit_q4_deg = limit_q4_deg
        self.beyond = False
        self.unknown = False  # and no longer permitted to move
        self._beyond_ms = 0
        self._clear_ms = 0
        self._level_ms = 0
        self._unseen_ms = 0
        self._moved_ms = 0

    # A sample of both angles, dt_ms after the one before. trusted: the sensor works as it should.
    # A slope is believed from any sensor, level ground only from a trusted one.
    def feed(self, roll_q4_deg, pitch_q4_deg, dt_ms, trusted):
        angle_q4_deg = max(abs(roll_q4_deg), abs(pitch_q4_deg))
        if angle_q4_deg > self.limit_q4_deg:
            self._beyond_ms += dt_ms if self._beyond_ms else _SAMPLE_MS
            if self._beyond_ms >= _BEYOND_MS:
                self._beyond_ms = _BEYOND_MS
                self.beyond = True
        elif self._beyond_ms:
            self._beyond_ms = max(0, self._beyond_ms - _SAMPLE_MS)
        if angle_q4_deg > self.limit_q4_deg - _HYSTERESIS_Q4_DEG:
            self._clear_ms = 0
        elif trusted:
            self._clear_ms = min(self._clear_ms + dt_ms, _CLEAR_MS)
            if self._clear_ms == _CLEAR_MS:
                self.beyond = False
        if angle_q4_deg > self.limit_q4_deg >> 1:
            self._level_ms = max(0, self._level_ms - _SPIKE_MS)
        elif trusted:
            self._level_ms = min(self._level_ms + dt_ms, _LEVEL_MS)

    # One tick passes. lost: the sensor cannot be read or believed; moving: a
    # motion is permitted; armed: else there is nothing to bound.
    def watch(self, elapsed_ms, lost, moving, armed):
        if not lost or not armed:
            self._unseen_ms = 0
            self._moved_ms = 0
            self.unknown = False
            return
        self._unseen_ms = min(self._unseen_ms + elapsed_ms, limits.AGE_MAX_MS)
        if moving:
            self._moved_ms = min(self._moved_ms + elapsed_ms, limits.AGE_MAX_MS)
        # The latest moment of detection; the rest is left for the output.
        found_ms = limits.HEADING_OLD_MS + limits.MARGIN_MS
        if (
            self._level_ms < _LEVEL_ENOUGH_MS
            or self._moved_ms >= limits.TILT_UNSEEN_MS - found_ms
            or self._unseen_ms >= limits.TILT_FORGOTTEN_MS - found_ms
        ):
            self.unknown = True
