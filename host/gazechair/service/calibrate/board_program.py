"""Runs on the board, in MicroPython: prints the BNO055's data from Adafruit's driver as JSON."""

import json
import select
import sys
import time

import machine

_I2C_HZ = 400_000
_TIMEOUT_US = 10_000  # the sensor stretches the clock; the default, 50 ms, may be too short
_TRIES, _RETRY_S = 30, 0.01
_WATCHDOG_MS = 128_000
_ID_REGISTER = b"\x00"
_FUSION_START_S = 0.2
_REPORT_S = 0.3


class BusioShape:
    """A machine.I2C with the interface of busio.I2C, for Adafruit's drivers."""

    def __init__(self, i2c: machine.I2C) -> None:
        self._i2c = i2c

    def try_lock(self) -> bool:
        """Always succeeds: there is no other user."""
        return True

    def unlock(self) -> None:
        """Nothing was locked."""

    def writeto(self, address: int, buffer, *, start=0, end=None) -> None:  # type: ignore
        """Write buffer[start:end]."""
        part = memoryview(buffer)[start : len(buffer) if end is None else end]
        _patiently(lambda: self._i2c.writeto(address, part))

    def readfrom_into(self, address: int, buffer, *, start=0, end=None) -> None:  # type: ignore
        """Fill buffer[start:end]."""
        part = memoryview(buffer)[start : len(buffer) if end is None else end]
        _patiently(lambda: self._i2c.readfrom_into(address, part))

    def writeto_then_readfrom(  # type: ignore
        self,
        address: int,
        out_buffer,
        in_buffer,
        *,
        out_start=0,
        out_end=None,
        in_start=0,
        in_end=None,
    ) -> None:
        """Write out_buffer[...], then fill in_buffer[...] after a repeated start."""
        out = memoryview(out_buffer)[out_start : len(out_buffer) if out_end is None else out_end]
        into = memoryview(in_buffer)[in_start : len(in_buffer) if in_end is None else in_end]

        def transfer() -> None:
            self._i2c.writeto(address, out, False)
            self._i2c.readfrom_into(address, into)

        _patiently(transfer)


# The driver waits 0.7 s for a reset, exactly its maximum.
def _patiently(transfer) -> None:  # type: ignore
    for _ in range(_TRIES - 1):
        try:
            transfer()
            return
        except OSError:
            time.sleep(_RETRY_S)
    transfer()


def run(bus: int, address: int, seconds: int) -> None:
    """Reset the sensor, run its fusion without magnetometer, and report until gyro and
    accelerometer are calibrated, the time is up, or a byte arrives.

    Prints {"chip_id": n}, then reports {"heading": clockwise degrees, "gyro_z": rad/s,
    "calibration": [system, gyro, accelerometer, magnetometer]}, or {"error": what} and ends.
    """
    stdin = select.poll()
    stdin.register(sys.stdin, select.POLLIN)
    watchdog = machine.WDT(timeout=_WATCHDOG_MS)
    watchdog.feed()
    try:
        sensor = _start(BusioShape(machine.I2C(bus, freq=_I2C_HZ, timeout=_TIMEOUT_US)), address)
        for _ in range(int(seconds / _REPORT_S)):
            time.sleep(_REPORT_S)
            watchdog.feed()
            calibration = sensor.calibration_status
            _tell(heading=sensor.euler[0], gyro_z=sensor.gyro[2], calibration=calibration)
            if calibration[1:3] == (3, 3):
                break
            if stdin.poll(0):
                sys.stdin.read(1)
                break
    except (OSError, RuntimeError, ValueError) as error:
        _tell(error=str(error))


def _start(shape: BusioShape, address: int):  # type: ignore
    chip_id = bytearray(1)
    shape.writeto_then_readfrom(address, _ID_REGISTER, chip_id)
    _tell(chip_id=chip_id[0])
    driver = __import__("adafruit_bno055")
    sensor = driver.BNO055_I2C(shape, address)
    sensor.mode = driver.IMUPLUS_MODE
    time.sleep(_FUSION_START_S)
    return sensor


def _tell(**what) -> None:  # type: ignore
    print(json.dumps(what))
