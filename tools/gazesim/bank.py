"""The register bank on the host's side: devices, pins and log, shared with a board by memory map.

Layout: gazeboard.boards.bank_layout. It serves the virtual board and the emulated Teensy.
"""

from __future__ import annotations

import mmap
import os
import struct
from dataclasses import dataclass

from gazeboard.boards import bank_layout as layout

_U32 = struct.Struct("<I")
_LOG = struct.Struct("<Q4B16sI")
LOG_KINDS = ("write", "read", "nak", "eio")


@dataclass(frozen=True)
class LogEntry:
    """One bus transfer as the board did it; `data` has at most its first 16 bytes."""

    number: int  # from 1
    time_us: int  # on the board's clock
    bus: int
    address: int
    kind: str  # one of LOG_KINDS
    length: int
    data: bytes


class Bank:
    """The whole bank. `buffer` is the shared memory itself, for a board in the same process."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Map the bank in file `path`; it is created (16 MiB) and formatted when needed."""
        fd = os.open(path, os.O_RDWR | os.O_CREAT, 0o600)
        try:
            if os.fstat(fd).st_size < layout.SIZE:
                os.ftruncate(fd, layout.SIZE)
            self._use(mmap.mmap(fd, layout.SIZE))
        finally:
            os.close(fd)

    @classmethod
    def in_memory(cls) -> Bank:
        """A bank over a bytearray, for a board that runs in lockstep in this process."""
        bank = cls.__new__(cls)
        bank._use(bytearray(layout.USED_SIZE))
        return bank

    def _use(self, buffer: mmap.mmap | bytearray) -> None:
        self.buffer = buffer
        self._log_read = 0
        known = (self.u32(layout.MAGIC_AT), self.u32(layout.VERSION_AT))
        if known != (layout.MAGIC, layout.VERSION):
            self.format()
        self._log_read = self.u32(layout.LOG_HEAD_AT)

    def format(self) -> None:
        """Empty it: no device present, no pin driven, flash erased."""
        self.buffer[0 : layout.FLASH_AT] = bytes(layout.FLASH_AT)
        self.buffer[layout.FLASH_AT : layout.FLASH_AT + layout.FLASH_SIZE] = (
            b"\xff" * layout.FLASH_SIZE
        )
        self.set_u32(layout.VERSION_AT, layout.VERSION)
        self.set_u32(layout.SIZE_AT, layout.USED_SIZE)
        self.set_u32(layout.MAGIC_AT, layout.MAGIC)  # last: now it may be used
        self._log_read = 0

    def close(self) -> None:
        """Release the mapping; the bank must not be used afterwards."""
        if isinstance(self.buffer, mmap.mmap):
            self.buffer.close()

    def u32(self, offset: int) -> int:
        """The unsigned 32-bit field at `offset`."""
        value: int = _U32.unpack_from(self.buffer, offset)[0]
        return value

    def set_u32(self, offset: int, value: int) -> None:
        """Set the unsigned 32-bit field at `offset`."""
        _U32.pack_into(self.buffer, offset, value)

    @property
    def tick_ms(self) -> int:
        """Ticks since the board's reset, modulo 2**32."""
        return self.u32(layout.TICK_MS_AT)

    @property
    def boot_count(self) -> int:
        """Hard boots of the board since the bank was formatted."""
        return self.u32(layout.BOOT_COUNT_AT)

    def power_on(self) -> None:
        """Let the board's next boot count as a power-on: no reset cause is handed over."""
        self.set_u32(layout.NEXT_CAUSE_AT, 0)

    def set_script(self, script: bytes) -> None:
        """Let the emulated Teensy's next boot, and only that one, run it in place of main.py.

        Raises ValueError when it is too long for its place.
        """
        if len(script) > layout.SCRIPT_SIZE:
            raise ValueError(f"a script of {len(script)} bytes: at most {layout.SCRIPT_SIZE} fit")
        self.buffer[layout.SCRIPT_AT : layout.SCRIPT_AT + len(script)] = script
        self.set_u32(layout.SCRIPT_DONE_AT, 0)
        self.set_u32(layout.SCRIPT_LEN_AT, len(script))

    def slot(self, bus: int, address: int) -> Slot:
        """The place of the device with 7-bit `address` on I2C bus `bus` (0..2)."""
        return Slot(self, bus, address)

    def pin(self, number: int) -> Pin:
        """The pin D`number` (0..63)."""
        return Pin(self, number)

    def stick_bus(self, bus: int, stuck: bool) -> None:
        """Hold SCL of `bus` low, or release it."""
        self.set_u32(layout.BUSES_AT + layout.BUS_SIZE * bus, int(stuck))

    def read_log(self) -> list[LogEntry]:
        """Transfers since the last call, oldest first; only the last 4096 are kept."""
        head = self.u32(layout.LOG_HEAD_AT)
        first = max(self._log_read, head - layout.LOG_ENTRIES)
        entries = []
        for index in range(first, head):
            at = layout.LOG_AT + (index % layout.LOG_ENTRIES) * layout.LOG_ENTRY_SIZE
            time_us, bus, address, kind, length, data, number = _LOG.unpack_from(self.buffer, at)
            if number != index + 1:  # overwritten or not finished
                continue
            entries.append(
                LogEntry(
                    number, time_us, bus, address, LOG_KINDS[kind], length, data[: min(length, 16)]
                )
            )
        self._log_read = head
        return entries


class Slot:
    """One I2C address: the registers of the device there and how it answers."""

    def __init__(self, bank: Bank, bus: int, address: int) -> None:
        self._bank = bank
        self._buffer = bank.buffer
        self.at = layout.SLOTS_AT + (bus * 128 + address) * layout.SLOT_SIZE
        self._regs_at = self.at + layout.SLOT_REGS

    def add(self, style: int) -> None:
        """Put a device there: bank_layout.STYLE_REGISTERS or STYLE_AD5282, registers zero."""
        self._buffer[self.at : self.at + layout.SLOT_SIZE] = bytes(layout.SLOT_SIZE)
        self._buffer[self.at + layout.SLOT_STYLE] = style
        self._buffer[self.at + layout.SLOT_PRESENT] = 1

    def set_nak(self, nak: bool) -> None:
        """Refuse every transfer, or stop doing so."""
        self._buffer[self.at + layout.SLOT_NAK] = int(nak)

    def set_nak_count(self, transfers: int) -> None:
        """Refuse the next `transfers` (0..255) transfers."""
        self._buffer[self.at + layout.SLOT_NAK_COUNT] = transfers

    def set_stretch_us(self, stretch_us: int) -> None:
        """Hold the clock for that long in every byte, address included."""
        self._bank.set_u32(self.at + layout.SLOT_STRETCH_US, stretch_us)

    def set_style(self, style: int) -> None:
        """Let it answer as another style of device; registers stay."""
        self._buffer[self.at + layout.SLOT_STYLE] = style

    def set_read_only(self, first: int, stop: int, read_only: bool = True) -> None:
        """Registers `first` .. `stop` - 1 ignore what the board writes, or take it again."""
        for register in range(first, stop):
            at, bit = self.at + layout.SLOT_RO + (register >> 3), 1 << (register & 7)
            self._buffer[at] = self._buffer[at] | bit if read_only else self._buffer[at] & ~bit

    @property
    def wseq(self) -> int:
        """Writes done by the board: compare to see whether there was one."""
        return self._bank.u32(self.at + layout.SLOT_WSEQ)

    @property
    def shut_down(self) -> int:
        """AD5282: bit 0 RDAC1, bit 1 RDAC2 shut down."""
        return self._buffer[self.at + layout.SLOT_SD]

    def set_shut_down(self, bits: int) -> None:
        """AD5282: set the shut-down bits, as its power-on does."""
        self._buffer[self.at + layout.SLOT_SD] = bits

    def read(self, register: int, count: int = 1) -> bytes:
        """`count` registers from `register` on."""
        at = self._regs_at + register
        return bytes(self._buffer[at : at + count])

    def write(self, register: int, data: bytes) -> None:
        """Update registers; the board sees all of it or none."""
        seq_at = self.at + layout.SLOT_HOST_SEQ
        seq = self._bank.u32(seq_at)
        self._bank.set_u32(seq_at, (seq + 1) | 1)
        at = self._regs_at + register
        self._buffer[at : at + len(data)] = data
        self._bank.set_u32(seq_at, (seq + 2) & 0xFFFFFFFE)


class Pin:
    """One pin of the board, seen from outside."""

    def __init__(self, bank: Bank, number: int) -> None:
        self._bank = bank
        self._buffer = bank.buffer
        self.at = layout.PINS_AT + number * layout.PIN_SIZE

    @property
    def mode(self) -> int:
        """0 in, 1 out, 2 open drain, 255 not configured."""
        return self._buffer[self.at + layout.PIN_MODE]

    @property
    def latch(self) -> int:
        """The board's output latch, 0 or 1."""
        return self._buffer[self.at + layout.PIN_OUT]

    @property
    def out_count(self) -> int:
        """Writes to the latch, modulo 2**32."""
        return self._bank.u32(self.at + layout.PIN_OUT_COUNT)

    def drive(self, level: int | None) -> None:
        """Drive the pad with `level` 0 or 1; None lets it float (a pull-up then reads 1)."""
        self._buffer[self.at + layout.PIN_HOST_LEVEL] = level or 0
        self._buffer[self.at + layout.PIN_HOST_DRIVE] = int(level is not None)
