# Heading check: compares each sample with the gyro and with earlier samples. Pure.
#
# One sample that contradicts the gyro is replaced by it; three within 50 ms are a jump. Bytes that
# stop changing are frozen (the gyro's own noise changes some bit of three axes at 100 Hz), and so
# is a heading that stays constant while the gyro turns. A sample read twice is neither good nor
# bad: sensor and board have clocks of their own, and while these drift apart some are read twice.

from gazeboard.core.angle import wrapped
from gazeboard.core.limits import HEADING_TURN_Q4_DEG
from gazelink import codes

_JUMP_Q4 = 48  # 3 degrees in one sample beyond the gyro's rotation
_JUMPS = 3
_JUMP_WINDOW_MS = 50
_DRIFT_WINDOW_MS = 500
_DRIFT_Q4 = 80  # 5 degrees between heading and integrated gyro in one window
_FROZEN_ARMED_MS = 38  # four samples that repeat one, with a read repeated among them
_FROZEN_RESTING_MS = 100
_LOST_MS = 10  # sooner, when a read was lost meanwhile
_STANDS_Q4 = 24  # 1.5 degrees by the gyro while the heading does not change at all
_TURNS_Q4_DPS = 32  # slower, the gyro's offset adds up
_GOOD_SAMPLES = 50  # 500 ms of them, none bad among them, clear a fault

_FROZEN = 1 << codes.HEADING_FROZEN
_JUMP = 1 << codes.HEADING_JUMP


class HeadingMonitor:
    def __init__(self):
        self.heading_q4 = 0  # counter-clockwise, 0..5759
        self.faults = 0
        self.restart()

    # Discard the past: the next sample is accepted as it is. Faults stay until 50 are good.
    def restart(self):
        self._anchored = False
        self._last_q4 = 0
        self._residue = 0
        self._same_ms = 0
        self._lost = False
        self._good = 0
        self._bad = 0
        self._since_bad_ms = 0
        self._window_ms = 0
        self._window_q4 = 0
        self._stood_q4 = 0

    # What the samples do not show: bits of the faults.
    def fault(self, bits):
        self.faults |= bits
        self._good = 0

    # A read failed: with the samples round it unchanged, it counts as one of them.
    def lost(self, armed):
        self._lost = True
        if armed and self._same_ms >= _FROZEN_ARMED_MS - _LOST_MS:
            self.fault(_FROZEN)

    # heading_q4: 0..5759; rate_q4: 1/16 degree/s; same: all bytes equal those of the sample before;
    # dt_ms: since the sample before, 1..100; armed: the board may turn the chair at any moment.
    def feed(self, heading_q4, rate_q4, same, dt_ms, armed):
        if not self._anchored:
            self._anchored = True
            self._last_q4 = heading_q4
            self.heading_q4 = heading_q4
            return
        self._residue += rate_q4 * dt_ms
        by_gyro_q4 = self._residue // 1000
        self._residue -= by_gyro_q4 * 1000
        soon = armed or self.faults != 0 or rate_q4 > 16 or rate_q4 < -16
        good = self._check_frozen(same, dt_ms, soon)
        good = self._check_stands(heading_q4, rate_q4, by_gyro_q4) and good
        predicted_q4 = (self.heading_q4 + by_gyro_q4) % HEADING_TURN_Q4_DEG
        if self._bad:
            self._since_bad_ms += dt_ms
            if self._since_bad_ms > _JUMP_WINDOW_MS:
                self._bad = 0
        reference_q4 = predicted_q4
        if self.faults & _JUMP:
            # Jumped: judge the new readings among themselves.
            reference_q4 = (self._last_q4 + by_gyro_q4) % HEADING_TURN_Q4_DEG
        error_q4 = wrapped(heading_q4 - reference_q4)
        parted_q4 = 0
        if -_JUMP_Q4 <= error_q4 <= _JUMP_Q4:
            parted_q4 = error_q4
            self.heading_q4 = heading_q4
        else:
            good = False
            self.heading_q4 = predicted_q4
            if self._bad == 0:
                self._since_bad_ms = 0
            self._bad += 1
            if self._bad >= _JUMPS:
                self.faults |= _JUMP
        self._last_q4 = heading_q4
        good = self._check_drift(parted_q4, dt_ms) and good
        if not good:
            self._good = 0
        elif not same:
            self._good = min(self._good + 1, _GOOD_SAMPLES)
        if self._good >= _GOOD_SAMPLES:
            self.faults = 0

    def _check_frozen(self, same, dt_ms, soon):
        self._same_ms = min(self._same_ms + dt_ms, _FROZEN_RESTING_MS) if same else 0
        limit_ms = _FROZEN_ARMED_MS if soon else _FROZEN_RESTING_MS
        if self._lost:
            limit_ms -= _LOST_MS
        self._lost = self._lost and same
        if self._same_ms < limit_ms:
            return True
        self.faults |= _FROZEN
        return False

    def _check_stands(self, heading_q4, rate_q4, by_gyro_q4):
        if heading_q4 != self._last_q4:
            self._stood_q4 = 0
        elif rate_q4 > _TURNS_Q4_DPS or rate_q4 < -_TURNS_Q4_DPS:
            self._stood_q4 = max(-_STANDS_Q4, min(_STANDS_Q4, self._stood_q4 + by_gyro_q4))
        if -_STANDS_Q4 < self._stood_q4 < _STANDS_Q4:
            return True
        self.faults |= _FROZEN
        return False

    # Heading and gyro may not part slowly either: a wrong fusion mode, a stuck axis.
    def _check_drift(self, parted_q4, dt_ms):
        self._window_q4 += parted_q4
        self._window_ms += dt_ms
        if self._window_ms < _DRIFT_WINDOW_MS:
            return True
        apart = not -_DRIFT_Q4 <= self._window_q4 <= _DRIFT_Q4
        self._window_ms = 0
        self._window_q4 = 0
        if apart:
            self.faults |= _JUMP
        return not apart
