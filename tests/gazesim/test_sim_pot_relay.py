"""Wipers, relay and switches, driven through the firmware's own bus and pins."""

import pytest

from gazeboard.boards import bank_layout as layout
from gazeboard.boards.bank_devices import BankI2C, BankPin, count_up, put_u32
from gazesim import pot, relay
from gazesim.bank import Bank
from gazesim.pot import Pot
from gazesim.relay import DROP_OUT_MS, PULL_IN_MS, Relay


class Board:
    """The part of a board that the relay sees: ticks and the enable line."""

    def __init__(self):
        self.bank = Bank.in_memory()
        self.enable = BankPin(self.bank.buffer, 2, True)
        self.feedback = BankPin(self.bank.buffer, 3, False)
        self.emergency = BankPin(self.bank.buffer, 4, False)
        self.button = BankPin(self.bank.buffer, 5, False)
        self.relay = Relay(self.bank, tick_stall_s=0.1)
        self.level = 0

    def ticks(self, count, toggle=True):
        for _ in range(count):
            if toggle:
                self.level ^= 1
                self.enable(self.level)
            count_up(self.bank.buffer, layout.TICK_MS_AT)
            self.relay.step(0.001)

    def stalls(self, ms):
        for _ in range(ms):
            self.relay.step(0.001)


def test_counts_and_volts():
    assert pot.volts(85) == pytest.approx(5.0)
    assert pot.volts(254) == pytest.approx(7.0)
    assert abs(pot.deflection(170)) < 0.01
    assert pot.deflection(254) == pytest.approx(1.0)
    assert pot.deflection(85) == pytest.approx(-1.0)
    assert pot.deflection(0) == -1.0


def test_power_on_is_midscale_which_is_not_neutral():
    wipers = Pot(Bank.in_memory()).poll()
    assert wipers == (128, 128)
    assert pot.deflection(128) < -0.4


def test_the_boards_writes_move_the_wipers_and_shut_down_drops_them():
    bank = Bank.in_memory()
    model, i2c = Pot(bank), BankI2C(bank.buffer, 0)
    i2c.writeto(0x2C, b"\x00\xc8")
    i2c.writeto(0x2C, b"\x80\x64")
    assert model.poll() == (200, 100)
    i2c.writeto(0x2C, b"\x20\xc8")
    assert model.poll() == (0, 100)


def stuck():
    """A potentiometer whose wipers are stuck at 0xAA (linear) and 0xAB, and its bus."""
    bank = Bank.in_memory()
    model, i2c = Pot(bank), BankI2C(bank.buffer, 0)
    i2c.writeto(0x2C, b"\x00\xaa")
    i2c.writeto(0x2C, b"\x80\xab")
    model.set_stuck(True)
    return model, i2c


def test_a_stuck_wiper_acknowledges_and_reads_back_wrong():
    model, i2c = stuck()
    got = bytearray(1)
    i2c.writeto(0x2C, b"\x00\xc8")
    i2c.readfrom_into(0x2C, got)
    assert got[0] != 0xC8
    assert model.poll() == (0xAA, 0xAB)
    model.set_stuck(False)
    assert model.poll() == (0xAA, 0xAB)
    i2c.writeto(0x2C, b"\x00\xc8")
    i2c.readfrom_into(0x2C, got)
    assert got[0] == 0xC8


def test_a_stuck_wiper_reads_back_right_until_another_value_is_written():
    """A read gives the wiper last selected, with data or without."""
    model, i2c = stuck()
    got = bytearray(1)
    for words, value in (
        (b"\x00\xaa", 0xAA),
        (b"\x80\xab", 0xAB),
        (b"\x80\xc8", 0xAB),
        (b"\x80", 0xAB),
        (b"\x00", 0xAA),
    ):
        i2c.writeto(0x2C, words)
        for _ in range(2):
            i2c.readfrom_into(0x2C, got)
            assert got[0] == value
    model.power_on()
    assert model.poll() == (0x80, 0x80)
    i2c.writeto(0x2C, b"\x80\xab")
    i2c.readfrom_into(0x2C, got)
    assert got[0] == 0x80


def test_the_relay_closes_with_toggling_and_shows_it():
    board = Board()
    assert board.feedback() == 0
    board.ticks(PULL_IN_MS - 1)
    assert not board.relay.closed
    board.ticks(2)
    assert board.relay.closed
    assert board.feedback() == 1


def test_it_opens_after_20_ticks_without_toggling():
    board = Board()
    board.ticks(50)
    board.ticks(DROP_OUT_MS - 1, toggle=False)
    assert board.relay.closed
    board.ticks(1, toggle=False)
    assert not board.relay.closed
    assert board.feedback() == 0


def test_writing_the_same_level_again_pumps_nothing():
    board = Board()
    for _ in range(50):
        board.enable(1)
        board.ticks(1, toggle=False)
    assert not board.relay.closed


def test_a_stalled_pc_is_not_a_stalled_board():
    board = Board()
    board.ticks(50)
    board.stalls(90)  # no tick and no toggle: the PC, so far
    assert board.relay.closed
    board.ticks(5)
    assert board.relay.closed
    board.stalls(101)  # now the board counts as stopped
    assert not board.relay.closed


def test_many_ticks_at_once_after_a_stall_keep_it_closed():
    board = Board()
    board.ticks(50)
    for _ in range(40):  # the board ran on, the simulator did not look
        board.level ^= 1
        board.enable(board.level)
        count_up(board.bank.buffer, layout.TICK_MS_AT)
    board.relay.step(0.001)
    assert board.relay.closed


def test_a_tick_counter_caught_between_two_bytes_does_no_harm():
    board = Board()
    put_u32(board.bank.buffer, layout.TICK_MS_AT, 0x1F0)
    board.ticks(15)  # 0x1FF
    board.bank.buffer[layout.TICK_MS_AT] = 0  # low byte wrapped, carry not yet there: 0x100
    board.relay.step(0.001)
    put_u32(board.bank.buffer, layout.TICK_MS_AT, 0x200)
    board.ticks(1)
    assert board.relay.closed


def test_a_board_that_restarts_opens_it():
    board = Board()
    put_u32(board.bank.buffer, layout.TICK_MS_AT, 100000)
    board.ticks(50)
    assert board.relay.closed
    put_u32(board.bank.buffer, layout.TICK_MS_AT, 0)
    board.ticks(DROP_OUT_MS + 2, toggle=False)
    assert not board.relay.closed


def test_a_contact_can_be_stuck_either_way():
    board = Board()
    board.relay.set_stuck(True)
    board.ticks(1, toggle=False)
    assert board.feedback() == 1
    board.relay.set_stuck(False)
    board.ticks(50)
    assert board.feedback() == 0
    board.relay.set_stuck(None)
    board.ticks(1)
    assert board.feedback() == 1


def test_emergency_input_and_button():
    board = Board()
    assert (board.emergency(), board.button()) == (0, 1)
    board.relay.press_emergency(True)
    board.relay.press_button(True)
    assert (board.emergency(), board.button()) == (1, 0)
    board.relay.press_emergency(False)
    board.relay.press_button(False)
    assert (board.emergency(), board.button()) == (0, 1)
    assert relay.EMERGENCY_PIN == 4
