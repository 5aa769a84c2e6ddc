"""The BNO055 on the bench, through Adafruit's driver: heading, gyro and calibration."""

from __future__ import annotations

import importlib
import math
import time
from dataclasses import asdict, dataclass
from typing import Any

from gazechair.service.bench import BenchError
from gazechair.service.bench.bus import Bus, BusioShape, answers

ADDRESSES = (0x28, 0x29)  # BNO055 data sheet: by its pin COM3
_FUSION_START_S = 0.2


@dataclass(frozen=True)
class ImuReading:
    """A reading; counter-clockwise positive, calibrations 0 (none) to 3 (full)."""

    heading_deg: float
    gyro_z_deg_s: float
    calibration_system: int
    calibration_gyro: int
    calibration_accelerometer: int

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def find(bus: Bus) -> int | None:
    """The first address that answers; None when none does."""
    return next((address for address in ADDRESSES if answers(bus, address)), None)


def read(bus: Bus, address: int) -> ImuReading:
    """Reset it, run its fusion without magnetometer, and take a reading.

    Raises BenchError when the driver is missing or the device is no BNO055, OSError when it stops
    answering.
    """
    try:
        driver: Any = importlib.import_module("adafruit_bno055")
    except (ImportError, NotImplementedError):
        raise BenchError(
            "Adafruit's BNO055 driver is not installed; run `pip install 'gazechair[bench]'`"
        ) from None
    try:
        sensor = driver.BNO055_I2C(BusioShape(bus), address)
    except RuntimeError as error:
        raise BenchError(f"what answers at {address:#04x} is no BNO055 ({error})") from None
    sensor.mode = driver.IMUPLUS_MODE
    time.sleep(_FUSION_START_S)
    heading_deg, gyro = sensor.euler[0], sensor.gyro
    if heading_deg is None or gyro[2] is None:
        raise BenchError(f"the BNO055 at {address:#04x} answers but does not measure; check supply")
    system, gyroscope, accelerometer, _ = sensor.calibration_status
    return ImuReading(-heading_deg % 360.0, math.degrees(gyro[2]), system, gyroscope, accelerometer)
