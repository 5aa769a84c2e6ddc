"""The AD5282 as the chair sees it: two wipers, from register to joystick deflection."""

from __future__ import annotations

from gazeboard.boards import bank_layout as layout
from gazesim.bank import Bank

BUS = 0
ADDRESS = 0x2C
POWER_ON_COUNT = 0x80  # midscale, which is not neutral
_HALF = 128  # registers for each wiper of a stuck potentiometer
NEUTRAL_V = 6.0
SWING_V = (
    1.0  # full deflection: what 85 and 254 counts give, and what the profile speeds were seen with
)


def volts(count: int) -> float:
    """Voltage of a wiper at `count` (0..255), in V: 85 gives 5 V, 254 gives 7 V."""
    return 5.0 + (count - 85) * 2.0 / 169.0


def deflection(count: int) -> float:
    """Joystick deflection at `count`, -1..1; neutral (170 counts) is within 0.01 of 0."""
    return max(-1.0, min(1.0, (volts(count) - NEUTRAL_V) / SWING_V))


class Pot:
    """The digital potentiometer in the bank: RDAC1 is linear, RDAC2 is turn."""

    def __init__(self, bank: Bank) -> None:
        self._slot = bank.slot(BUS, ADDRESS)
        self._slot.add(layout.STYLE_AD5282)
        self._nak = False
        self._stuck = False
        self.power_on()

    def power_off(self) -> None:
        """Its supply is gone: it answers nothing."""
        self._slot.set_nak(True)

    def power_on(self) -> None:
        """Both wipers to midscale, as after its supply came up."""
        self._put(POWER_ON_COUNT, POWER_ON_COUNT)
        self._slot.set_shut_down(0)
        self._slot.set_nak(self._nak)

    def _counts(self) -> tuple[int, int]:
        registers = self._slot.read(0, _HALF + 1 if self._stuck else 2)
        return registers[0], registers[-1]

    def _put(self, linear: int, turn: int) -> None:
        if self._stuck:
            # A register file that takes no write. The instruction's highest bit selects the wiper;
            # here it selects the half of the registers in which the next read goes on.
            self._slot.write(0, bytes((linear,)) * _HALF + bytes((turn,)) * _HALF)
        else:
            self._slot.write(0, bytes((linear, turn)))

    def poll(self) -> tuple[int, int]:
        """The wipers now: (linear, turn) counts. A wiper that is shut down is at its B end, 0."""
        linear, turn = self._counts()
        shut_down = self._slot.shut_down
        return (0 if shut_down & 1 else linear, 0 if shut_down & 2 else turn)

    def set_nak(self, nak: bool) -> None:
        """Fault: answers no transfer."""
        self._nak = nak
        self._slot.set_nak(nak)

    def set_stuck(self, stuck: bool) -> None:
        """Fault: acknowledges every write but the wipers stay: reading back shows it as soon as
        another value is written."""
        counts = self._counts()
        self._stuck = stuck
        self._slot.set_style(layout.STYLE_REGISTERS if stuck else layout.STYLE_AD5282)
        self._slot.set_read_only(0, 2 * _HALF, stuck)
        self._put(*counts)
