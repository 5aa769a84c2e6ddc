"""The AD5282 on the bench: reads both wipers back, and sweeps them over the joystick's range."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from gazechair.service.bench.bus import Bus, answers

ADDRESSES = (0x2C, 0x2D, 0x2E, 0x2F)  # AD5282 data sheet: by its pins AD1 and AD0
WIPERS = ("linear", "turn")
_INSTRUCTIONS = (0x00, 0x80)
LOWEST, NEUTRAL, HIGHEST = 85, 170, 254  # counts: 5 V, about 6 V, 7 V at the DB9; as the
# board's limits, which cannot be read here: a test compares
_SWEEP = (*range(NEUTRAL, HIGHEST, 12), HIGHEST, NEUTRAL, *range(LOWEST, NEUTRAL, 12), NEUTRAL)


@dataclass(frozen=True)
class SweepResult:
    """One wiper's sweep: how many counts were written, which did not read back."""

    wiper: str
    written: int
    wrong: tuple[int, ...]

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


class Pot:
    """The potentiometer at one address. Every call raises OSError when it does not answer."""

    def __init__(self, bus: Bus, address: int) -> None:
        self._bus = bus
        self.address = address

    def read(self, wiper: int) -> int:
        """Count of wiper 0 (linear) or 1 (turn): select it by an instruction alone, then read."""
        self._bus.write(self.address, bytes((_INSTRUCTIONS[wiper],)))
        return self._bus.read(self.address, 1)[0]

    def write(self, wiper: int, count: int) -> None:
        """Set a wiper."""
        self._bus.write(self.address, bytes((_INSTRUCTIONS[wiper], count)))

    def sweep(self, wiper: int) -> SweepResult:
        """Neutral, to the highest, to the lowest, to neutral; the other wiper stays as it is."""
        wrong = []
        for count in _SWEEP:
            self.write(wiper, count)
            if self.read(wiper) != count:
                wrong.append(count)
        return SweepResult(WIPERS[wiper], len(_SWEEP), tuple(wrong))

    def to_neutral(self) -> bool:
        """Both wipers to neutral, both tried; whether both read back so."""
        good = True
        for wiper in range(len(WIPERS)):
            try:
                self.write(wiper, NEUTRAL)
                good = self.read(wiper) == NEUTRAL and good
            except OSError:
                good = False
        return good


def find(bus: Bus) -> Pot | None:
    """The first one that answers; None when none does."""
    for address in ADDRESSES:
        if answers(bus, address):
            return Pot(bus, address)
    return None
