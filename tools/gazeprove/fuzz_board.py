"""The board that the fuzzed firmware runs on: registers, pins, line and files, all spoilable.

It offers what gazeboard/boards/__init__.py asks of a board and records what goes out. Nothing in
here looks into the firmware.
"""

from __future__ import annotations

import random
from collections import deque
from typing import Any

from gazeboard.io.storage import Files

TICKS = 1 << 30  # the clocks wrap here
_HALF = 1 << 29
_NAK = 19
_STUCK = 5
_NEUTRAL_AT_BOOT = 170

# How the potentiometer fails: not at all, no answer, bus stuck, writes lost, reads wrong.
OK, NAK, STUCK, DEAF, LYING = range(5)


class Pot:
    """An AD5282 at register level. `failed` says whether anything went wrong since it was reset."""

    def __init__(self) -> None:
        self.registers = [0x80, 0x80]
        self._selected = 0
        self.fault = OK
        self.fails_for = -1  # transfers until it works again; -1: until told
        self.failed = False
        self.illegal: list[bytes] = []  # writes that no data sheet and no promise asks for

    def _begin(self) -> bool:
        """True when this transfer works; raises OSError as the bus does."""
        if self.fault == OK:
            return True
        if self.fails_for == 0:
            self.fault = OK
            self.fails_for = -1
            return True
        if self.fails_for > 0:
            self.fails_for -= 1
        if self.fault in (NAK, STUCK):
            self.failed = True
            raise OSError(_NAK if self.fault == NAK else _STUCK)
        return False

    def writeto(self, _address: int, data: bytes) -> int:
        """An instruction byte and a value."""
        works = self._begin()
        if len(data) != 2 or data[0] not in (0x00, 0x80) or not 85 <= data[1] <= 254:
            self.illegal.append(bytes(data))
        self._selected = data[0] >> 7
        if works or self.fault == LYING:
            self.registers[self._selected] = data[1]
        elif self.registers[self._selected] != data[1]:
            self.failed = True
        return len(data) + 1

    def readfrom_into(self, _address: int, buf: bytearray) -> None:
        """The register last selected."""
        works = self._begin()
        value = self.registers[self._selected]
        if not works and self.fault == LYING:
            value ^= 0x10
            self.failed = True
        for k in range(len(buf)):
            buf[k] = value


class ImuBus:
    """A BNO055's register file on its own bus."""

    def __init__(self) -> None:
        self.registers = bytearray(256)
        self.fault = OK
        self._pointer = 0
        self.power_on()

    def power_on(self) -> None:
        """What the registers hold after a reset: CONFIG mode, no data."""
        self.registers[:] = bytes(256)
        self.registers[0] = 0xA0
        self.registers[0x3B] = 0x80

    def _begin(self) -> None:
        if self.fault:
            raise OSError(_STUCK if self.fault == STUCK else _NAK)

    def writeto(self, _address: int, data: bytes) -> int:
        """A register number and what goes there."""
        self._begin()
        self._pointer = data[0]
        for value in data[1:]:
            self.registers[self._pointer] = value
            self._pointer = (self._pointer + 1) & 0xFF
        return len(data) + 1

    def readfrom_mem_into(self, _address: int, register: int, buf: bytearray) -> None:
        """Read from a register on."""
        self._begin()
        buf[:] = self.registers[register : register + len(buf)]

    def readfrom_into(self, _address: int, buf: bytearray) -> None:
        """Read on."""
        self.readfrom_mem_into(_address, self._pointer, buf)


class Serial:
    """The line: what was pushed is read byte by byte, what is sent is kept until it is taken."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._at = 0
        self._base = 0  # of _bytes[0], counted from the start of the line
        self.marks: deque[tuple[int, Any]] = deque()  # (end of a frame, whose frame)
        self.sent = bytearray()
        self.reading = True  # False: the host takes nothing
        self.takes = 0  # bytes at a time; 0: all

    def read_byte(self) -> int:
        """The next byte, or -1."""
        at = self._at
        if at < len(self._bytes):
            self._at = at + 1
            return self._bytes[at]
        return -1

    def write_some(self, buf: bytearray, start: int, end: int) -> int:
        """Take bytes; the index of the first one not taken."""
        if not self.reading:
            return start
        if self.takes:
            end = min(end, start + self.takes)
        self.sent += buf[start:end]
        return end

    def push(self, data: bytes, whose: Any) -> None:
        """Bytes towards the board; `whose` comes back from taken() once all of them were read."""
        if self._at == len(self._bytes):
            self._base += self._at
            self._bytes.clear()
            self._at = 0
        self._bytes += data
        self.marks.append((self._base + len(self._bytes), whose))

    def taken(self) -> list[Any]:
        """Whose frames have been read to their end since the last call."""
        read = self._base + self._at
        done = []
        while self.marks and self.marks[0][0] <= read:
            done.append(self.marks.popleft()[1])
        return done

    def cut(self) -> None:
        """What is on its way is lost."""
        self._base += len(self._bytes)
        self._bytes.clear()
        self._at = 0
        self.marks.clear()
        self.sent.clear()


class SpoiltFiles:
    """The virtual board's own files, in a folder that can be full."""

    def __init__(self, folder: str) -> None:
        self._files = Files(folder)
        self.full = False

    def load(self, name: str) -> str | None:
        """As the virtual board reads it."""
        text: str | None = self._files.load(name)
        return text

    def store(self, name: str, text: str) -> None:
        """Keep it, or fail as a full flash does."""
        if self.full:
            raise OSError(28)
        self._files.store(name, text)

    def remove(self, name: str) -> None:
        """Forget it: a full flash does that."""
        self._files.remove(name)


class Board:
    """One life of the board between two resets. Clocks, pins and devices outlive it."""

    name = "fuzzed"
    hard_timer = True

    def draw_nonce(self, nonce: bytearray) -> None:
        """Random for each session."""
        nonce[0:4] = self._nonces.randbytes(4)

    def __init__(self, world: World, boot_id: int, reset_cause: int) -> None:
        self._world = world
        self.simulated = world.simulated
        self.boot_id = boot_id
        self.reset_cause = reset_cause
        self._nonces = random.Random(boot_id)
        self.joystick_i2c = world.pot
        self.imu_i2c = world.imu
        self.serial = world.serial
        world.enable = 0
        self._neutral_first()
        self.load = world.files.load
        self.store = world.files.store
        self.remove = world.files.remove

    def _neutral_first(self) -> None:
        """What main.py does before any import (P1); stands here because main.py runs no fuzzer."""
        pot = self._world.pot
        try:
            pot.writeto(0x2C, bytes((0x00, _NEUTRAL_AT_BOOT)))
            pot.writeto(0x2C, bytes((0x80, _NEUTRAL_AT_BOOT)))
        except OSError:
            pass

    def enable_pin(self, level: int) -> int:
        """The enable line."""
        self._world.enable = level
        return level

    def led_pin(self, level: int) -> int:
        """Nobody looks."""
        return level

    def relay_pin(self) -> int:
        """High: the contact is closed. Raises what the world says a tick shall raise."""
        world = self._world
        if world.raises is not None:
            error = world.raises
            world.raises = None
            raise error
        return int(world.relay_closed)

    def emergency_pin(self) -> int:
        """High: emergency."""
        return self._world.emergency_level

    def button_pin(self) -> int:
        """Low: pressed."""
        return self._world.button_level

    def ticks_us(self) -> int:
        """Microseconds, wrapping."""
        return self._world.now_us % TICKS

    def ticks_ms(self) -> int:
        """Milliseconds, wrapping likewise."""
        return self._world.now_us // 1000 % TICKS

    def ticks_diff(self, a: int, b: int) -> int:
        """a - b of wrapped clocks."""
        return ((a - b + _HALF) & (TICKS - 1)) - _HALF

    def feed_watchdog(self) -> None:
        """The watchdog is content."""
        self._world.feeds += 1
        self._world.fed_us = self._world.now_us

    def heap_free_kb(self) -> int:
        """The computer's memory says nothing about the board's."""
        return 0

    def open_repl(self) -> None:
        """There is none."""


class World:
    """What outlives a reset of the board: its clock, its pins, its devices, its files."""

    def __init__(self, folder: str, simulated: bool, start_us: int) -> None:
        self.simulated = simulated
        self.now_us = start_us
        self.pot = Pot()
        self.imu = ImuBus()
        self.serial = Serial()
        self.files = SpoiltFiles(folder)
        self.enable = 0
        self.relay_closed = False
        self.emergency_level = 0
        self.button_level = 1
        self.raises: Exception | None = None
        self.feeds = 0
        self.fed_us = start_us
        self.imu_failed_us = -1  # since when its bus fails; -1: it does not

    def spoil_imu(self, fault: int) -> None:
        """The heading sensor's bus fails from now on, or works again."""
        self.imu.fault = fault
        if fault == OK:
            self.imu_failed_us = -1
        elif self.imu_failed_us < 0:
            self.imu_failed_us = self.now_us
