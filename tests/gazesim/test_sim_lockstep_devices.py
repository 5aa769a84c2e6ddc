"""The fast buses and pins of a chair in lockstep behave like those of the virtual board."""

import random
from collections.abc import Callable
from typing import Any

import pytest

from gazeboard.boards import bank_devices, pins
from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank
from gazesim.bno055 import ADDRESS as IMU
from gazesim.bno055 import Bno055
from gazesim.lockstep_devices import LockstepI2C, LockstepPin
from gazesim.pot import ADDRESS as POT
from gazesim.pot import Pot


class Board:
    """A bank with both devices, and the buses and pins of one kind over it."""

    def __init__(self, i2c: type, pin: type) -> None:
        self.bank = Bank.in_memory()
        self.pot = Pot(self.bank)
        self.imu = Bno055(self.bank)
        self.buses = [i2c(self.bank.buffer, bus) for bus in (pins.JOYSTICK_BUS, pins.IMU_BUS)]
        self.out = pin(self.bank.buffer, pins.ENABLE, True)
        self.into = pin(self.bank.buffer, pins.BUTTON, False)

    def bytes(self) -> bytes:
        """Its whole observable state."""
        return bytes(self.bank.buffer[: layout.LOG_AT])


def did(action: Callable[..., Any], *words: Any) -> Any:
    """What it returned, or the error."""
    try:
        return action(*words)
    except OSError as error:
        return error.args


def something(dice: random.Random, board: Board) -> list[Any]:
    """Do a transfer, set a pin, or inject a fault; returns what the firmware gets."""
    kind = dice.choice(("wiper", "wiper", "write", "read", "read", "registers", "pin", "fault"))
    bus, address = board.buses[dice.choice((0, 0, 1))], dice.choice((POT, POT, IMU, 0x11))
    back = bytearray(dice.choice((1, 1, 2, 12)))
    if kind == "wiper":
        words = bytearray((dice.choice((0x00, 0x80)), dice.randrange(256)))
        return [did(bus.writeto, address, words)]
    if kind == "write":
        words = bytearray(dice.randrange(256) for _ in range(dice.choice((1, 2, 2, 3))))
        return [did(bus.writeto, address, words)]
    if kind == "read":
        return [did(bus.readfrom_into, address, back), back]
    if kind == "registers":
        return [did(bus.readfrom_mem_into, address, dice.randrange(256), back), back]
    if kind == "pin":
        board.bank.pin(pins.BUTTON).drive(dice.choice((None, 0, 1)))
        return [board.out(dice.choice((0, 1))), board.into()]
    board.bank.stick_bus(0, dice.random() < 0.3)
    board.pot.set_nak(dice.random() < 0.3)
    board.pot.set_stuck(dice.random() < 0.3)
    board.bank.slot(0, POT).set_nak_count(dice.choice((0, 0, 2)))
    return []


@pytest.mark.parametrize("seed", range(4))
def test_whatever_a_board_does_the_bank_is_the_same(seed):
    plain = Board(bank_devices.BankI2C, bank_devices.BankPin)
    quick = Board(LockstepI2C, LockstepPin)
    one, other = random.Random(seed), random.Random(seed)
    for _ in range(3000):  # counters pass 255 in it
        assert something(one, quick) == something(other, plain)
    assert quick.bytes() == plain.bytes()
    assert plain.bank.pin(pins.ENABLE).out_count > 255
