# BNO055 in IMUPLUS mode (no magnetometer): start-up, 100 Hz reads, recovery.
#
# It has the service loop's own bus. Registers and times: Bosch BST-BNO055-DS000. Each poll() does
# at most one short transfer; nothing waits. The burst reads all three gyro axes with the heading,
# because their noise distinguishes a working sensor from a frozen one, and the tilt (0x14..0x1F),
# which must be equally fresh.

from gazeboard.core.limits import RATE_MAX_Q4_DPS
from gazeboard.core.tilt import Tilt
from gazeboard.io.heading import HeadingMonitor
from gazelink import codes

ADDRESS = 0x28
_CHIP_ID = 0x00
_BURST = 0x14  # gyro x y z, heading, roll, pitch: 6 x int16, 1/16 deg/s and 1/16 degree
_BURST_SIZE = 12
_HEADING_SIZE = 8  # gyro and heading: what never stays the same
_CALIBRATION = 0x35  # sys<<6, gyro<<4, accelerometer<<2, magnetometer: 3 is calibrated
_OFFSETS = 0x55  # 22 bytes, only in CONFIG
OFFSETS_SIZE = 22
_STATUS = 0x39  # SYS_STATUS, SYS_ERR, UNIT_SEL, (reserved), OPR_MODE
_UNIT_SEL = 0x3B
_OPR_MODE = 0x3D
_MODE_CONFIG = 0x00
_MODE_IMUPLUS = 0x08
_ID = 0xA0
_SYSTEM_ERROR = 0x01

_SAMPLE_MS = 10
_TO_CONFIG_MS = 20
_FROM_CONFIG_MS = 10
_FUSION_START_MS = 100
_RETRY_MS = 100
_RETRY_MAX_MS = 1600
_RETRY_READ_MS = 2  # a first lost read must not cost a sample's time
_BUS_ERRORS = 4  # in a row: fault (32 ms)
_GIVE_UP_ERRORS = 7  # in a row: start the sensor again
_TICKS = 0x3FFFFFFF  # the clock wraps here; the Teensy's ticks_diff misreads what is beyond
_HALF_TICKS = 0x20000000

_PROBE = 0
_CONFIGURE = 1
_START = 2
_SETTLE = 3
_RUN = 4
_TO_SAVE = 5
_SAVE = 6


def _s16(low, high):
    value = low | (high << 8)
    return value - 65536 if value & 0x8000 else value


class Imu:
    # poll(now_ms, ...) with the board's millisecond clock; results go to the attributes.

    def __init__(self, i2c, ticks_diff, tilt_limit_q4_deg):
        self._i2c = i2c
        self._ticks_diff = ticks_diff
        self.tilt = Tilt(tilt_limit_q4_deg)
        self._monitor = HeadingMonitor()
        self._now = bytearray(_BURST_SIZE)
        self._before = bytearray(_BURST_SIZE)
        self._status = bytearray(5)
        self._one = bytearray(1)
        self._offsets = bytearray(1 + OFFSETS_SIZE)  # behind their register number
        self._offsets[0] = _OFFSETS
        self._read_offsets = bytearray(OFFSETS_SIZE)
        self._have_offsets = False
        self.offsets_new = False  # read from the sensor since save()
        self.calibration = 0  # from the sensor's register
        self._two = bytearray(2)
        self._state = _PROBE
        self._due_ms = 0
        self._scheduled = False
        self._last_ms = 0
        self._turn = 0  # of the four-sample rota of extra reads
        self._extra = False
        self._errors_in_row = 0
        self._retried = False
        self._retry_ms = _RETRY_MS
        self.heading_q4 = 0
        self.rate_q4 = 0
        self.faults = 0
        self.samples = 0  # counts good samples: a new value means new data
        self.errors = 0

    # Returns True when there is a new sample. armed: the chair may be turned at any moment.
    def poll(self, now_ms, armed):
        if not self._scheduled:
            self._scheduled = True
            self._due_ms = now_ms
        late_ms = self._ticks_diff(now_ms, self._due_ms)
        if late_ms < 0:
            if self._extra:
                self._extra = False
                self._look_aside(now_ms, armed)
            return False
        self._due_in(now_ms, _SAMPLE_MS - late_ms % _SAMPLE_MS if late_ms < 1000 else 0)
        try:
            fresh = self._work(now_ms, armed)
            self._errors_in_row = 0
            if self._retried and fresh:
                self._due_in(self._due_ms, -_RETRY_READ_MS)  # the samples keep their times
            self._retried = False
        except OSError:
            fresh = False
            self._failed(now_ms, armed)
            if self._state == _RUN and not self._retried:
                self._retried = True
                self._due_in(now_ms, _RETRY_READ_MS)
        self.faults = self._monitor.faults
        return fresh

    # The sensor cannot be read or trusted, so the tilt is not known.
    def tilt_lost(self):
        return self.faults & codes.TILT_LOST != 0

    def _work(self, now_ms, armed):
        if self._state == _RUN:
            return self._sample(now_ms, armed)
        if self._state == _PROBE:
            self._i2c.readfrom_mem_into(ADDRESS, _CHIP_ID, self._one)
            if self._one[0] != _ID:
                raise OSError(19)
            self._write(_OPR_MODE, _MODE_CONFIG)
            self._next(now_ms, _CONFIGURE, _TO_CONFIG_MS)
        elif self._state == _CONFIGURE:
            self._write(_UNIT_SEL, 0)  # m/s2, deg/s, degrees, Celsius
            if self._have_offsets:
                self._i2c.writeto(ADDRESS, self._offsets)
            self._next(now_ms, _START, 1)
        elif self._state == _START:
            self._write(_OPR_MODE, _MODE_IMUPLUS)
            self._next(now_ms, _SETTLE, _FROM_CONFIG_MS + _FUSION_START_MS)
        elif self._state == _TO_SAVE:
            self._write(_OPR_MODE, _MODE_CONFIG)
            self._next(now_ms, _SAVE, _TO_CONFIG_MS)
        elif self._state == _SAVE:
            self._i2c.readfrom_mem_into(ADDRESS, _OFFSETS, self._read_offsets)
            for k in range(OFFSETS_SIZE):
                self._offsets[1 + k] = self._read_offsets[k]
            self._have_offsets = True
            self.offsets_new = True
            self._next(now_ms, _START, 1)
        else:
            self._monitor.restart()
            self._retry_ms = _RETRY_MS
            self._last_ms = now_ms
            self._next(now_ms, _RUN, _SAMPLE_MS)
        return False

    # Calibration of an earlier run, to be given back at the next start of the sensor.
    def restore(self, offsets):
        for k in range(OFFSETS_SIZE):
            self._offsets[1 + k] = offsets[k]
        self._have_offsets = True

    # Fully calibrated (gyro and accelerometer; the magnetometer is not used) and running?
    def calibrated(self):
        return self._state == _RUN and self.calibration & 0x3C == 0x3C

    # Read the sensor's offsets; fusion stops for some 50 ms, so only while disarmed.
    def save(self):
        self._state = _TO_SAVE
        self._extra = False
        self.offsets_new = False

    # False: they are new, or the sensor was lost meanwhile.
    def saving(self):
        return self._state == _TO_SAVE or self._state == _SAVE

    def offsets(self):
        return self._offsets[1:]

    def _next(self, now_ms, state, delay_ms):
        self._state = state
        self._due_in(now_ms, delay_ms)

    # Wrapped as the clock is, half of it off meanwhile: no sum leaves the small integers.
    def _due_in(self, now_ms, delay_ms):
        self._due_ms = (now_ms - _HALF_TICKS + delay_ms) & _TICKS ^ _HALF_TICKS

    def _write(self, register, value):
        self._two[0] = register
        self._two[1] = value
        self._i2c.writeto(ADDRESS, self._two)

    def _sample(self, now_ms, armed):
        new = self._now
        old = self._before
        self._i2c.readfrom_mem_into(ADDRESS, _BURST, new)
        same = True
        for k in range(_HEADING_SIZE):
            if new[k] != old[k]:
                same = False
                old[k] = new[k]
        dt_ms = max(1, min(100, self._ticks_diff(now_ms, self._last_ms)))
        self._last_ms = now_ms
        self.rate_q4 = max(-RATE_MAX_Q4_DPS, min(RATE_MAX_Q4_DPS, _s16(new[4], new[5])))
        clockwise_q4 = _s16(new[6], new[7])
        if not 0 <= clockwise_q4 <= 5760:
            clockwise_q4 = clockwise_q4 % 5760  # no angle: let the monitor see the jump
        monitor = self._monitor
        monitor.feed(-clockwise_q4 % 5760, self.rate_q4, same, dt_ms, armed)
        self.heading_q4 = monitor.heading_q4
        trusted = not same and monitor.faults & codes.TILT_LOST == 0
        self.tilt.feed(_s16(new[8], new[9]), _s16(new[10], new[11]), dt_ms, trusted)
        self.samples = (self.samples + 1) & 0xFFFF
        self._turn = (self._turn + 1) & 3
        self._extra = self._turn & 1 == 1
        return True

    # Every other sample, in the pass after it: mode and errors, now and then the calibration. One
    # short transfer a pass.
    def _look_aside(self, now_ms, armed):
        try:
            if self._turn == 3 and self.samples & 63 == 63:
                self._i2c.readfrom_mem_into(ADDRESS, _CALIBRATION, self._one)
                self.calibration = self._one[0]
            else:
                self._check_status(now_ms)
        except OSError:
            self._failed(now_ms, armed)
        self.faults = self._monitor.faults

    def _check_status(self, now_ms):
        self._i2c.readfrom_mem_into(ADDRESS, _STATUS, self._status)
        status = self._status
        if status[0] == _SYSTEM_ERROR or status[2] != 0 or status[4] != _MODE_IMUPLUS:
            self._monitor.fault(1 << codes.HEADING_RESET)
            self._next(now_ms, _PROBE, _SAMPLE_MS)

    def _failed(self, now_ms, armed):
        self.errors = (self.errors + 1) & 0xFFFF
        self._errors_in_row += 1
        self._monitor.lost(armed)
        if self._errors_in_row >= _BUS_ERRORS or self._state != _RUN:
            self._monitor.fault(1 << codes.HEADING_BUS)
        if self._state != _RUN:
            self._next(now_ms, _PROBE, self._retry_ms)
            self._retry_ms = min(_RETRY_MAX_MS, self._retry_ms * 2)
        elif self._errors_in_row >= _GIVE_UP_ERRORS:
            self._next(now_ms, _PROBE, _RETRY_MS)
