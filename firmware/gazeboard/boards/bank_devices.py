# I2C buses and pins of the virtual board, over a register bank.
#
# Same effects and counters as on the emulated board (bank_layout.py), but no transfer log, and a
# transfer takes no time. No allocation: counters are advanced byte by byte, never as 32-bit
# integers.

from gazeboard.boards import bank_layout as at


def u32(bank, offset):
    return (
        bank[offset] | (bank[offset + 1] << 8) | (bank[offset + 2] << 16) | (bank[offset + 3] << 24)
    )


def put_u32(bank, offset, value):
    for k in range(4):
        bank[offset + k] = (value >> (8 * k)) & 0xFF


def count_up(bank, offset):
    for k in range(4):
        value = bank[offset + k] + 1
        bank[offset + k] = value & 0xFF
        if value < 256:
            return


class BankI2C:
    # machine.I2C's non-allocating calls. NAK is OSError 19 (ENODEV), a stuck bus OSError 5 (EIO).

    def __init__(self, bank, bus):
        self._bank = bank
        self._bus_at = at.BUSES_AT + bus * at.BUS_SIZE
        self._slots_at = at.SLOTS_AT + bus * 128 * at.SLOT_SIZE

    def writeto(self, addr, buf):
        slot = self._begin(addr)
        n = len(buf)
        bank = self._bank
        if n:
            if bank[slot + at.SLOT_STYLE] == at.STYLE_AD5282:
                self._write_ad5282(slot, buf, n)
            else:
                self._write_registers(slot, buf, n)
        count_up(bank, slot + at.SLOT_WSEQ)
        return n + 1

    def readfrom_into(self, addr, buf):
        slot = self._begin(addr)
        self._read(slot, buf)

    def readfrom_mem_into(self, addr, register, buf):
        slot = self._begin(addr)
        self._bank[slot + at.SLOT_REGPTR] = register
        count_up(self._bank, slot + at.SLOT_WSEQ)
        self._read(slot, buf)

    def _begin(self, addr):
        bank = self._bank
        if bank[self._bus_at] & 1:
            raise OSError(5)
        slot = self._slots_at + addr * at.SLOT_SIZE
        count_up(bank, self._bus_at + 4)
        if bank[slot + at.SLOT_PRESENT] and not bank[slot + at.SLOT_NAK]:
            if bank[slot + at.SLOT_NAK_COUNT] == 0:
                return slot
            bank[slot + at.SLOT_NAK_COUNT] -= 1
        count_up(bank, slot + at.SLOT_NAKS)
        raise OSError(19)

    def _write_registers(self, slot, buf, n):
        bank = self._bank
        pointer = buf[0]
        for k in range(1, n):
            if not bank[slot + at.SLOT_RO + (pointer >> 3)] & (1 << (pointer & 7)):
                bank[slot + at.SLOT_REGS + pointer] = buf[k]
            pointer = (pointer + 1) & 0xFF
        bank[slot + at.SLOT_REGPTR] = pointer

    def _write_ad5282(self, slot, buf, n):
        bank = self._bank
        instruction = buf[0]
        channel = instruction >> 7
        bank[slot + at.SLOT_REGPTR] = instruction
        bank[slot + at.SLOT_SEL] = channel
        bank[slot + at.SLOT_PINS] = ((instruction >> 4) & 1) | ((instruction >> 2) & 2)
        shut = bank[slot + at.SLOT_SD] & ~(1 << channel)
        bank[slot + at.SLOT_SD] = shut | (((instruction >> 5) & 1) << channel)
        if instruction & 0x40:
            bank[slot + at.SLOT_REGS + channel] = 0x80
        elif n > 1:
            bank[slot + at.SLOT_REGS + channel] = buf[n - 1]

    # The host updates a block of registers under a sequence number: odd while it writes.
    def _read(self, slot, buf):
        bank = self._bank
        n = len(buf)
        for _ in range(100):
            before = bank[slot + at.SLOT_HOST_SEQ]
            if bank[slot + at.SLOT_STYLE] == at.STYLE_AD5282:
                for k in range(n):
                    buf[k] = bank[slot + at.SLOT_REGS + bank[slot + at.SLOT_SEL]]
            else:
                pointer = bank[slot + at.SLOT_REGPTR]
                for k in range(n):
                    buf[k] = bank[slot + at.SLOT_REGS + ((pointer + k) & 0xFF)]
            if before & 1 == 0 and bank[slot + at.SLOT_HOST_SEQ] == before:
                break
        if bank[slot + at.SLOT_STYLE] != at.STYLE_AD5282:
            bank[slot + at.SLOT_REGPTR] = (bank[slot + at.SLOT_REGPTR] + n) & 0xFF
        count_up(bank, slot + at.SLOT_RSEQ)


class BankPin:
    # A pin called as machine.Pin is: pin(level) drives the latch, pin() reads the pad.

    def __init__(self, bank, number, output):
        self._bank = bank
        self._at = at.PINS_AT + number * at.PIN_SIZE
        bank[self._at + at.PIN_MODE] = 1 if output else 0
        bank[self._at + at.PIN_PULL] = 4 if output else 2

    def __call__(self, level=None):
        bank = self._bank
        if level is None:
            # An input with a pull-up: high unless the host drives it.
            value = 1
            if bank[self._at + at.PIN_HOST_DRIVE]:
                value = bank[self._at + at.PIN_HOST_LEVEL]
            bank[self._at + at.PIN_LEVEL] = value
            return value
        bank[self._at + at.PIN_OUT] = level
        bank[self._at + at.PIN_LEVEL] = level
        count_up(bank, self._at + at.PIN_OUT_COUNT)
        return level
