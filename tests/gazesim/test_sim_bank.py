"""The register bank from the simulator's side, the firmware's own bus and pins on the other."""

import pytest

from gazeboard.boards import bank_layout as layout
from gazeboard.boards.bank_devices import BankI2C, BankPin, count_up
from gazesim.bank import Bank


def test_a_new_file_is_formatted_and_found_again(tmp_path):
    bank = Bank(tmp_path / "bank")
    assert bank.u32(layout.MAGIC_AT) == layout.MAGIC
    assert bank.buffer[layout.FLASH_AT] == 0xFF
    assert (tmp_path / "bank").stat().st_size == layout.SIZE
    bank.set_u32(layout.SEED_AT, 77)
    bank.close()
    again = Bank(tmp_path / "bank")
    assert again.u32(layout.SEED_AT) == 77
    again.close()


def test_a_file_that_is_no_bank_is_formatted(tmp_path):
    (tmp_path / "bank").write_bytes(b"x" * layout.SIZE)
    bank = Bank(tmp_path / "bank")
    assert bank.boot_count == 0
    assert bank.u32(layout.VERSION_AT) == layout.VERSION
    bank.close()


def test_registers_written_here_are_read_by_the_board_and_back():
    bank = Bank.in_memory()
    slot = bank.slot(1, 0x28)
    slot.add(layout.STYLE_REGISTERS)
    slot.write(0x10, b"\x01\x02")
    slot.set_read_only(0x11, 0x12)
    i2c = BankI2C(bank.buffer, 1)
    got = bytearray(2)
    i2c.readfrom_mem_into(0x28, 0x10, got)
    assert got == b"\x01\x02"
    before = slot.wseq
    i2c.writeto(0x28, b"\x10\x07\x08")
    assert slot.wseq == before + 1
    assert slot.read(0x10, 2) == b"\x07\x02"  # 0x11 is read only


def test_a_device_can_be_absent_refuse_or_hang_its_bus():
    bank = Bank.in_memory()
    i2c = BankI2C(bank.buffer, 0)
    with pytest.raises(OSError, match="19"):
        i2c.writeto(0x2C, b"\0\0")
    slot = bank.slot(0, 0x2C)
    slot.add(layout.STYLE_AD5282)
    i2c.writeto(0x2C, b"\0\x55")
    slot.set_nak_count(1)
    with pytest.raises(OSError, match="19"):
        i2c.writeto(0x2C, b"\0\x56")
    i2c.writeto(0x2C, b"\0\x57")
    bank.stick_bus(0, True)
    with pytest.raises(OSError, match="5"):
        i2c.writeto(0x2C, b"\0\x58")
    bank.stick_bus(0, False)
    assert slot.read(0) == b"\x57"


def test_pins_both_ways():
    bank = Bank.in_memory()
    button = BankPin(bank.buffer, 5, False)
    assert button() == 1  # pull-up
    bank.pin(5).drive(0)
    assert button() == 0
    bank.pin(5).drive(None)
    assert button() == 1
    enable = BankPin(bank.buffer, 2, True)
    enable(1)
    assert (bank.pin(2).latch, bank.pin(2).out_count, bank.pin(2).mode) == (1, 1, 1)


def test_the_log_is_read_once_and_in_order():
    bank = Bank.in_memory()
    assert bank.read_log() == []
    for number in (1, 2):
        at = layout.LOG_AT + (number - 1) * layout.LOG_ENTRY_SIZE
        entry = (number * 100).to_bytes(8, "little") + bytes((0, 0x2C, layout.LOG_WRITE, 2))
        entry += b"\x80\xaa".ljust(16, b"\0") + number.to_bytes(4, "little")
        bank.buffer[at : at + 32] = entry
        count_up(bank.buffer, layout.LOG_HEAD_AT)
    first, second = bank.read_log()
    assert (first.number, first.time_us, first.address, first.kind) == (1, 100, 0x2C, "write")
    assert second.data == b"\x80\xaa"
    assert bank.read_log() == []
