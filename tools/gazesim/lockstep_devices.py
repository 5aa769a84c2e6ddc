"""The virtual board's buses, pins and counters, optimised for CPython.

`bank_devices` may not allocate, so it counts byte by byte, and a chair in lockstep would spend a
tenth of its time there. All effects on the bank are the same; rare cases are left to that module.
"""

from __future__ import annotations

from mmap import mmap
from typing import Any

from gazeboard.boards import bank_layout as at
from gazeboard.boards import pins
from gazeboard.boards.bank_devices import BankI2C, BankPin, count_up
from gazesim.lockstep import Clock, LockstepBoard

Buffer = mmap | bytearray


def _count(bank: Buffer, offset: int) -> None:
    low = bank[offset]
    if low < 255:
        bank[offset] = low + 1
    else:
        count_up(bank, offset)


class LockstepI2C(BankI2C):
    """One bus."""

    def __init__(self, bank: Buffer, bus: int) -> None:
        super().__init__(bank, bus)  # type: ignore[no-untyped-call]
        self._bytes = bank
        self._flags_at = at.BUSES_AT + bus * at.BUS_SIZE
        self._first_slot = at.SLOTS_AT + bus * 128 * at.SLOT_SIZE

    def _answering_pot(self, slot: int) -> bool:
        bank = self._bytes
        return (
            bank[slot + at.SLOT_STYLE] == at.STYLE_AD5282
            and bank[slot + at.SLOT_PRESENT] != 0
            and not (bank[slot + at.SLOT_NAK] or bank[slot + at.SLOT_NAK_COUNT])
            and not bank[self._flags_at] & 1
        )

    def writeto(self, addr: int, buf: bytearray) -> int:
        """A wiper's count for a working potentiometer; anything else as in `bank_devices`."""
        bank, slot = self._bytes, self._first_slot + addr * at.SLOT_SIZE
        if len(buf) != 2 or buf[0] & 0x7F or not self._answering_pot(slot):
            return int(super().writeto(addr, buf))  # type: ignore[no-untyped-call]
        channel = buf[0] >> 7
        bank[slot + at.SLOT_REGPTR] = buf[0]
        bank[slot + at.SLOT_SEL] = channel
        bank[slot + at.SLOT_PINS] = 0
        bank[slot + at.SLOT_SD] &= ~(1 << channel)
        bank[slot + at.SLOT_REGS + channel] = buf[1]
        _count(bank, self._flags_at + 4)
        _count(bank, slot + at.SLOT_WSEQ)
        return 3

    def readfrom_into(self, addr: int, buf: bytearray) -> None:
        """The wiper last written, of a working potentiometer; else as in `bank_devices`."""
        bank, slot = self._bytes, self._first_slot + addr * at.SLOT_SIZE
        if len(buf) != 1 or not self._answering_pot(slot):
            super().readfrom_into(addr, buf)  # type: ignore[no-untyped-call]
            return
        buf[0] = bank[slot + at.SLOT_REGS + bank[slot + at.SLOT_SEL]]
        _count(bank, self._flags_at + 4)
        _count(bank, slot + at.SLOT_RSEQ)


class LockstepPin(BankPin):
    """One pin."""

    def __init__(self, bank: Buffer, number: int, output: bool) -> None:
        super().__init__(bank, number, output)  # type: ignore[no-untyped-call]
        self._bytes = bank
        self._pin_at = at.PINS_AT + number * at.PIN_SIZE

    def __call__(self, level: int | None = None) -> int:
        """Drive the latch, or read the pad."""
        bank, pin = self._bytes, self._pin_at
        if level is None:
            level = bank[pin + at.PIN_HOST_LEVEL] if bank[pin + at.PIN_HOST_DRIVE] else 1
        else:
            bank[pin + at.PIN_OUT] = level
            _count(bank, pin + at.PIN_OUT_COUNT)
        bank[pin + at.PIN_LEVEL] = level
        return level


class QuickBoard(LockstepBoard):
    """A LockstepBoard with these devices."""

    def __init__(self, bank: Buffer, serial: Any, files: Any, boot_id: int, clock: Clock) -> None:
        super().__init__(bank, serial, files, boot_id, clock)  # type: ignore[no-untyped-call]
        self._bytes = bank
        self.joystick_i2c = LockstepI2C(bank, pins.JOYSTICK_BUS)
        self.imu_i2c = LockstepI2C(bank, pins.IMU_BUS)
        self.enable_pin = LockstepPin(bank, pins.ENABLE, True)
        self.led_pin = LockstepPin(bank, pins.LED, True)
        self.relay_pin = LockstepPin(bank, pins.RELAY_FEEDBACK, False)
        self.emergency_pin = LockstepPin(bank, pins.EMERGENCY, False)
        self.button_pin = LockstepPin(bank, pins.BUTTON, False)

    def feed_watchdog(self) -> None:
        """Counted in the bank."""
        _count(self._bytes, at.WDT_FEEDS_AT)

    def tick(self, app: Any) -> None:
        """One tick, counted in the bank."""
        app.tick()
        _count(self._bytes, at.TICK_MS_AT)
