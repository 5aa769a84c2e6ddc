"""The BNO055 at register level: mode timing, fusion values, write protection and its faults."""

import struct

import pytest

from gazeboard.boards.bank_devices import BankI2C
from gazesim.bank import Bank
from gazesim.bno055 import CONFIG, IMUPLUS, Bno055

ADDRESS = 0x28
STEP_S = 0.001


class Bench:
    """A sensor and the bus a board reads it by."""

    def __init__(self, seed=1):
        bank = Bank.in_memory()
        self.sensor = Bno055(bank, seed)
        self.i2c = BankI2C(bank.buffer, 1)

    def run(self, ms, rate=0.0):
        for _ in range(ms):
            self.sensor.step(STEP_S, rate)

    def write(self, register, value):
        self.i2c.writeto(ADDRESS, bytes((register, value)))

    def read(self, register, count=1):
        data = bytearray(count)
        self.i2c.readfrom_mem_into(ADDRESS, register, data)
        return bytes(data)

    def fusion(self):
        self.write(0x3B, 0)
        self.run(1)
        self.write(0x3D, IMUPLUS)
        self.run(30)

    def heading_deg(self):
        """Clockwise, as the sensor gives it."""
        return struct.unpack("<H", self.read(0x1A, 2))[0] / 16

    def rate_deg_s(self):
        return struct.unpack("<h", self.read(0x18, 2))[0] / 16


def test_it_says_what_it_is_and_is_silent_in_config():
    bench = Bench()
    bench.run(100, rate=50.0)
    assert bench.read(0x00, 4) == b"\xa0\xfb\x32\x0f"
    assert bench.read(0x36) == b"\x0f"
    assert bench.read(0x08, 46) == bytes(46)
    assert bench.sensor.mode == CONFIG


def test_from_config_takes_7_ms_and_to_config_19():
    bench = Bench()
    bench.write(0x3D, IMUPLUS)
    bench.run(6)
    assert bench.sensor.mode == CONFIG
    bench.run(2)
    assert bench.sensor.mode == IMUPLUS
    assert bench.read(0x39) == b"\x05"  # fusion runs
    bench.run(100)
    bench.write(0x3D, CONFIG)
    bench.run(18)
    assert bench.sensor.mode == IMUPLUS
    bench.run(2)
    assert bench.sensor.mode == CONFIG
    assert bench.read(0x08, 46) == bytes(46)


def test_a_reset_answers_nothing_for_650_to_700_ms_and_forgets():
    bench = Bench()
    bench.fusion()
    bench.write(0x3F, 0x20)
    bench.run(2)
    with pytest.raises(OSError, match="19"):
        bench.read(0x00)
    bench.run(640)
    with pytest.raises(OSError, match="19"):
        bench.read(0x00)
    bench.run(60)
    assert bench.read(0x3D) == b"\x00"
    assert bench.read(0x3B) == b"\x80"
    assert bench.read(0x3F) == b"\x00"


def test_values_are_new_every_10_ms():
    bench = Bench()
    bench.fusion()
    changes, last = 0, bench.read(0x14, 8)
    for _ in range(1000):
        bench.run(1)
        now = bench.read(0x14, 8)
        changes += now != last
        last = now
    assert 95 <= changes <= 100  # noise makes nearly every sample differ


def test_heading_is_clockwise_from_0_and_gyro_counter_clockwise():
    bench = Bench()
    bench.fusion()
    bench.run(1000, rate=10.0)  # to the left
    assert bench.rate_deg_s() == pytest.approx(10.0, abs=1.0)
    assert bench.heading_deg() == pytest.approx(350.0, abs=1.0)
    bench.run(2000, rate=-10.0)
    assert bench.rate_deg_s() == pytest.approx(-10.0, abs=1.0)
    assert bench.heading_deg() == pytest.approx(10.0, abs=1.0)


def test_heading_stays_within_a_turn():
    bench = Bench()
    bench.fusion()
    for _ in range(80):
        bench.run(100, rate=90.0)
        assert 0 <= bench.heading_deg() < 360


def test_scale_and_drift_differ_by_seed_and_are_small():
    headings = []
    for seed in (1, 1, 2):
        bench = Bench(seed)
        bench.fusion()
        bench.run(36000, rate=-10.0)
        headings.append(bench.heading_deg())
    assert headings[0] == headings[1] != headings[2]
    for heading in headings:
        assert min(heading, 360 - heading) < 3.0


def test_units_are_obeyed():
    bench = Bench()
    bench.write(0x3B, 0x06)  # radians, radians per second
    bench.run(1)
    bench.write(0x3D, IMUPLUS)
    bench.run(30)
    bench.run(500, rate=-57.29578)
    assert struct.unpack("<h", bench.read(0x18, 2))[0] / 900 == pytest.approx(-1.0, abs=0.05)
    assert struct.unpack("<H", bench.read(0x1A, 2))[0] / 900 == pytest.approx(0.5, abs=0.1)


def test_units_and_offsets_are_writable_in_config_only():
    bench = Bench()
    bench.write(0x55, 0x11)
    bench.run(1)
    bench.fusion()
    bench.write(0x3B, 0x81)
    bench.write(0x55, 0x22)
    bench.run(1)
    assert bench.read(0x3B) == b"\x00"
    assert bench.read(0x55) == b"\x11"
    bench.write(0x1A, 0xFF)  # a measured value: read only
    assert bench.heading_deg() < 2 or bench.heading_deg() > 358


def test_calibration_comes_by_itself_without_the_magnetometer():
    bench = Bench()
    bench.fusion()
    assert bench.read(0x35)[0] >> 4 & 3 == 0
    bench.run(3000)
    assert bench.read(0x35)[0] >> 4 & 3 == 3
    assert bench.read(0x35)[0] & 3 == 0


def test_tilt_shows_in_roll_pitch_and_gravity():
    bench = Bench()
    bench.fusion()
    bench.sensor.set_tilt(5.0, 20.0)
    bench.run(20)
    roll, pitch = struct.unpack("<2h", bench.read(0x1C, 4))
    assert (roll / 16, pitch / 16) == (5.0, 20.0)
    x, _, z = struct.unpack("<3h", bench.read(0x2E, 6))
    assert x / 100 == pytest.approx(-9.81 * 0.342, abs=0.05)
    assert z / 100 == pytest.approx(9.81 * 0.936, abs=0.1)


def test_frozen_values_stand_still_and_go_on():
    bench = Bench()
    bench.fusion()
    bench.sensor.set_frozen(True)
    before = bench.read(0x14, 8)
    bench.run(500, rate=20.0)
    assert bench.read(0x14, 8) == before
    bench.sensor.set_frozen(False)
    bench.run(20, rate=20.0)
    assert bench.heading_deg() == pytest.approx(350.0, abs=1.0)


def test_a_spike_is_one_sample():
    bench = Bench()
    bench.fusion()
    bench.sensor.set_spike(90.0)
    off = 0
    for _ in range(600):
        bench.run(10)
        off += 45 < bench.heading_deg() < 315
    assert 2 <= off <= 7  # one in 1..3 s


def test_a_self_reset_is_silent():
    bench = Bench()
    bench.fusion()
    bench.run(100, rate=20.0)
    bench.sensor.self_reset()
    assert bench.read(0x3D) == b"\x00"
    assert bench.read(0x14, 8) == bytes(8)
    bench.run(100, rate=20.0)
    assert bench.read(0x14, 8) == bytes(8)


def test_a_jump_stays_and_an_error_shows():
    bench = Bench()
    bench.fusion()
    bench.sensor.jump(-30.0)
    bench.run(100)
    assert bench.heading_deg() == pytest.approx(30.0, abs=0.5)
    bench.sensor.set_error(3)
    assert bench.read(0x39, 2) == b"\x01\x03"
    bench.sensor.set_error(0)
    assert bench.read(0x39, 2) == b"\x05\x00"


def test_nak_survives_a_reset():
    bench = Bench()
    bench.sensor.set_nak(True)
    bench.sensor.reset()
    bench.run(800)
    with pytest.raises(OSError, match="19"):
        bench.read(0x00)
    bench.sensor.set_nak(False)
    assert bench.read(0x00) == b"\xa0"


def test_a_sensor_that_is_down_does_not_reset_itself():
    for goes_down in (Bno055.power_on, Bno055.reset):
        bench = Bench()
        goes_down(bench.sensor)
        bench.run(100)
        bench.sensor.self_reset()
        bench.run(800)
        assert bench.read(0x00) == b"\xa0"
