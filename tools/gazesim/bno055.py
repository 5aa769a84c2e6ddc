"""The BNO055 at register level: modes and their timing, fusion at 100 Hz, and its known faults.

Registers and times: Bosch BST-BNO055-DS000 rev. 1.4 and the faults seen in the field. Page 0 only.
"""

from __future__ import annotations

import math
import random
import struct

from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.imu_model import Imu, ImuErrors

BUS = 1
ADDRESS = 0x28
CONFIG = 0x00
IMUPLUS = 0x08  # fusion of gyro and accelerometer, no magnetometer
FUSION_MODES = (0x08, 0x09, 0x0A, 0x0B, 0x0C)

_DATA = 0x08  # accelerometer, first of the measured values
_CALIBRATION = 0x35
_SELF_TEST = 0x36
_STATUS = 0x39
_UNIT_SEL = 0x3B
_OPR_MODE = 0x3D
_TRIGGER = 0x3F
_END = 0x6B

_DATA_LENGTH = _CALIBRATION - _DATA
_STATUS_IDLE, _STATUS_ERROR, _STATUS_FUSION, _STATUS_RAW = 0, 1, 5, 6
_RESET_BIT = 0x20
_TO_CONFIG_S = 0.019
_FROM_CONFIG_S = 0.007
_RESET_S = (0.650, 0.700)
_START_UP_S = 0.400  # from power to CONFIG
_GRAVITY = 9.80665
# Written in CONFIG mode only: units, power, temperature source, axes, offsets.
_CONFIG_ONLY = (*range(0x3B, 0x3D), 0x3E, *range(0x40, 0x43), *range(0x55, _END))


class Bno055:
    """The sensor in its slot. `step` passes the chair's motion; everything else is registers.

    Heading is clockwise 0..360 and starts at 0 with the fusion; gyro z is counter-clockwise
    positive. Its errors (see imu_model) follow from the seed.
    """

    def __init__(self, bank: Bank, seed: int = 1) -> None:
        self._slot = bank.slot(BUS, ADDRESS)
        self._random = random.Random(seed)
        self._imu = Imu(ImuErrors.drawn(self._random), seed)
        self._frozen = False
        self._nak = False
        self._spike: tuple[float, float] | None = None  # size deg, seconds to the next
        self._tilt_deg = (0.0, 0.0)  # roll, pitch
        self._slot.add(layout.STYLE_REGISTERS)
        self._slot.set_read_only(0x00, 0x07)
        self._slot.set_read_only(_DATA, _UNIT_SEL)
        self._reset_registers()

    def _reset_registers(self) -> None:
        registers = bytearray(0x80)
        registers[0:7] = bytes((0xA0, 0xFB, 0x32, 0x0F, 0x11, 0x03, 0x15))
        registers[_SELF_TEST] = 0x0F
        registers[_UNIT_SEL] = 0x80
        registers[0x41:0x43] = bytes((0x24, 0x00))
        self._slot.write(0, bytes(registers))
        self._wseq = self._slot.wseq
        self._config = bytes(registers)
        self.mode = CONFIG
        self._next_mode = CONFIG
        self._switch_s = 0.0
        self._down_s = 0.0
        self._running_s = 0.0

    def step(self, dt_s: float, yaw_rate_deg_s: float, acceleration_m_s2: float = 0.0) -> None:
        """Advance by `dt_s` (at most one sample period) while the chair turns at that rate."""
        if self._down_s > 0.0:
            self._down_s -= dt_s
            if self._down_s <= 0.0:
                self._reset_registers()
                self._slot.set_nak(self._nak)
            return
        wseq = self._slot.wseq
        if wseq != self._wseq:
            self._wseq = wseq
            self._obey()
        if self._switch_s > 0.0:
            self._switch_s -= dt_s
            if self._switch_s <= 1e-9:
                self._enter(self._next_mode)
        if self.mode == CONFIG:
            return
        self._running_s += dt_s
        if self._spike is not None:
            self._spike = (self._spike[0], self._spike[1] - dt_s)
        if self._imu.step(dt_s, yaw_rate_deg_s) and not self._frozen:
            self._sample(acceleration_m_s2)

    def _obey(self) -> None:
        registers = bytearray(self._slot.read(0, _END))
        if registers[_TRIGGER] & _RESET_BIT:
            self.reset()
            return
        if registers[_TRIGGER]:
            self._slot.write(_TRIGGER, b"\0")  # write-only: reads as zero
        if self.mode == CONFIG and self._switch_s <= 0.0:
            self._config = bytes(registers)
        else:
            for register in _CONFIG_ONLY:
                if registers[register] != self._config[register]:
                    self._slot.write(register, self._config[register : register + 1])
        wanted = registers[_OPR_MODE] & 0x0F
        if wanted != self._next_mode:
            self._next_mode = wanted
            leave_s = _TO_CONFIG_S if self.mode != CONFIG else 0.0
            self._switch_s = leave_s + (_FROM_CONFIG_S if wanted != CONFIG else 0.0)

    def _enter(self, mode: int) -> None:
        self.mode = mode
        self._switch_s = 0.0
        self._running_s = 0.0
        self._imu.restart()
        self._slot.write(_DATA, bytes(_DATA_LENGTH + 1))
        fusion = _STATUS_FUSION if mode in FUSION_MODES else _STATUS_RAW
        self._slot.write(_STATUS, bytes((_STATUS_IDLE if mode == CONFIG else fusion,)))

    def _sample(self, acceleration_m_s2: float) -> None:
        gauss = self._random.gauss
        roll_deg, pitch_deg = self._tilt_deg
        heading_deg = self._imu.heading_deg
        if self._spike is not None and self._spike[1] <= 0.0:
            heading_deg += self._spike[0]
            self._spike = (self._spike[0], self._random.uniform(1.0, 3.0))
        units = self._config[_UNIT_SEL]
        per_deg_s = 900.0 * math.pi / 180.0 if units & 2 else 16.0
        per_deg = 900.0 * math.pi / 180.0 if units & 4 else 16.0
        turn = 360.0 * per_deg
        heading = int(-heading_deg * per_deg % turn) % int(turn)
        noise = self._imu.errors.noise_deg_s
        gyro = (gauss(0.0, noise), gauss(0.0, noise), self._imu.rate_deg_s)
        roll, pitch, yaw = (math.radians(a) for a in (roll_deg, pitch_deg, self._imu.heading_deg))
        gravity = (
            -_GRAVITY * math.sin(pitch),
            _GRAVITY * math.sin(roll) * math.cos(pitch),
            _GRAVITY * math.cos(roll) * math.cos(pitch),
        )
        linear = (acceleration_m_s2 + gauss(0.0, 0.02), gauss(0.0, 0.02), gauss(0.0, 0.02))
        values = [
            *[int((g + a) * 100) for g, a in zip(gravity, linear, strict=True)],
            *(0, 0, 0),  # magnetometer
            *[round(rate * per_deg_s) for rate in gyro],
            heading,
            int(roll_deg * per_deg),
            int((-pitch_deg if units & 0x80 else pitch_deg) * per_deg),
            *[int(q * 16384) for q in _quaternion(roll, pitch, yaw)],
            *[int(a * 100) for a in linear],
            *[int(g * 100) for g in gravity],
        ]
        if min(values) < -32768 or max(values) > 32767:
            values = [max(-32768, min(32767, value)) for value in values]
        data = struct.pack(f"<{len(values)}h", *values)
        self._slot.write(_DATA, data + bytes((24, self._calibration())))  # 24 degrees Celsius

    def _calibration(self) -> int:
        gyro = min(3, int(self._running_s / 0.7))
        accelerometer = min(3, int(self._running_s / 5.0))
        return min(gyro, 3) << 6 | gyro << 4 | accelerometer << 2

    def reset(self) -> None:
        """Reset: answers nothing for 650..700 ms, then is in CONFIG with its default registers."""
        self._slot.set_nak(True)
        self._down_s = self._random.uniform(*_RESET_S)

    def power_off(self) -> None:
        """Its supply is gone: it answers nothing."""
        self._slot.set_nak(True)
        self._down_s = math.inf

    def power_on(self) -> None:
        """A cold start: answers nothing for 400 ms, then is as after a reset."""
        self._slot.set_nak(True)
        self._down_s = _START_UP_S

    def self_reset(self) -> None:
        """Fault: it silently falls back to CONFIG, with all its outputs zero, unless it is down."""
        if self._down_s <= 0.0:
            self._reset_registers()

    def set_nak(self, nak: bool) -> None:
        """Fault: answers no transfer."""
        self._nak = nak
        self._slot.set_nak(nak or self._down_s > 0.0)

    def set_tilt(self, roll_deg: float, pitch_deg: float) -> None:
        """The chair stands on a slope."""
        self._tilt_deg = (roll_deg, pitch_deg)

    def set_frozen(self, frozen: bool) -> None:
        """Fault: it answers, but the values stand still."""
        self._frozen = frozen

    def set_spike(self, spike_deg: float | None) -> None:
        """Fault: every 1..3 s one sample's heading is off by that much; None ends it."""
        self._spike = None if spike_deg is None else (spike_deg, 0.0)

    def jump(self, jump_deg: float) -> None:
        """Fault: from now on the heading is off by that much."""
        self._imu.jump(jump_deg)

    def set_error(self, code: int) -> None:
        """Fault: SYS_ERR shows `code` and SYS_STATUS "system error"; 0 ends it."""
        running = _STATUS_IDLE if self.mode == CONFIG else _STATUS_FUSION
        self._slot.write(_STATUS, bytes((_STATUS_ERROR if code else running, code)))

    def set_stretch_us(self, stretch_us: int) -> None:
        """Clock stretching per byte, where the bus knows time; the real one takes about 180."""
        self._slot.set_stretch_us(stretch_us)


def _quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
