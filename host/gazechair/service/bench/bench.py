"""Runs `gazechair bench`: lists the bus, reads the devices, and sweeps if allowed."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from gazechair.service.bench import BenchError, imu, pot
from gazechair.service.bench.bus import Bus
from gazechair.service.bench.pot import Pot

CONFIRMATION = "unplugged"
QUESTION = (
    "The sweep moves both wipers from 5 V to 7 V: a chair on the DB9 would drive.\n"
    "A Teensy on this bus must not run its firmware, which writes both wipers, too.\n"
    f"Pull the DB9 plug and type '{CONFIRMATION}'; anything else leaves the sweep out: "
)
_PINS = (1, 2)  # of the DB9, by wiper
# (count, what the meter shows), as docs/wiring.md has it
_METER = (
    (pot.LOWEST, "5 V, never below 4.8 V"),
    (pot.NEUTRAL, "6 V, about as pin 3 does"),
    (pot.HIGHEST, "7 V, never above 7.2 V"),
)


class Bench:
    """One run on `bus`. `say` gets each line for the user; `ask` asks them a question."""

    def __init__(self, bus: Bus, say: Callable[[str], None], ask: Callable[[str], str]) -> None:
        self._bus = bus
        self._say = say
        self._ask = ask
        self.findings: dict[str, Any] = {}

    def run(self, db9_unplugged: bool) -> bool:
        """Check everything; True when every device is present and reads as it should.

        `db9_unplugged`: already confirmed by the user. Raises BenchError when a device stops
        answering or a library is missing.
        """
        good = self._check_pot(db9_unplugged)
        good = self._check_imu() and good
        self.findings["ok"] = good
        return good

    def as_json(self) -> str:
        """The findings as one line."""
        return json.dumps(self.findings)

    def _check_pot(self, db9_unplugged: bool) -> bool:
        found = pot.find(self._bus)
        if found is None:
            self.findings["pot"] = None
            self._say(
                "AD5282: nothing answers at 0x2c..0x2f; check its supply, SDA, SCL and pull-ups"
            )
            return False
        try:
            wipers = [found.read(wiper) for wiper in range(len(pot.WIPERS))]
        except OSError as error:
            raise BenchError(f"{_name(found)} stopped answering ({error}); check wiring") from None
        self.findings["pot"] = {"address": found.address, "wipers": wipers, "sweep": None}
        self._say(f"{_name(found)}: linear {wipers[0]}, turn {wipers[1]} (neutral {pot.NEUTRAL})")
        if db9_unplugged:
            return self._sweep(found, hold=False)
        if self._ask(QUESTION).strip().lower() != CONFIRMATION:
            self._say("sweep left out: nobody said that the DB9 is unplugged")
            return True
        return self._sweep(found, hold=True)

    def _sweep(self, found: Pot, hold: bool) -> bool:
        """`hold`: a person with a meter is there."""
        results = []
        try:
            for wiper in range(len(pot.WIPERS)):
                results.append(found.sweep(wiper))
            if hold and not any(result.wrong for result in results):
                for wiper in range(len(pot.WIPERS)):
                    self._hold(found, wiper)
        except OSError as error:
            raise BenchError(f"{_name(found)} stopped answering ({error}); check wiring") from None
        finally:  # whatever happened, Ctrl-C included
            neutral = found.to_neutral()
            self._say(
                f"both wipers back to neutral ({pot.NEUTRAL})"
                if neutral
                else "NOT back to neutral: keep the DB9 unplugged and take the supply away"
            )
        for result in results:
            wrong = ", ".join(map(str, result.wrong))
            verdict = f"wrong at {wrong}" if wrong else "all read back"
            self._say(f"sweep of {result.wiper}: {result.written} counts, {verdict}")
        self.findings["pot"]["sweep"] = [result.as_dict() for result in results]
        self.findings["pot"]["neutral"] = neutral
        if neutral and not hold:
            self._say("a read-back proves the register, not the voltage: measure it now")
        return neutral and not any(result.wrong for result in results)

    def _hold(self, found: Pot, wiper: int) -> None:
        """Keep the wiper at each count of which the meter shows the voltage, until Enter."""
        for count, meter in _METER:
            found.write(wiper, count)
            self._ask(
                f"{pot.WIPERS[wiper]} stays at {count}: DB9 pin {_PINS[wiper]} against ground"
                f" (pin 8) must show {meter}. Press Enter: "
            )
            if found.read(wiper) != count:
                raise BenchError(
                    f"something else moved the wiper {pot.WIPERS[wiper]} from {count}; stop the"
                    " firmware on this bus (docs/wiring.md) and measure again"
                )
        found.write(wiper, pot.NEUTRAL)

    def _check_imu(self) -> bool:
        address = imu.find(self._bus)
        if address is None:
            self.findings["imu"] = None
            self._say("BNO055: nothing answers at 0x28 or 0x29; check its supply, SDA, SCL")
            return False
        try:
            reading = imu.read(self._bus, address)
        except OSError as error:
            raise BenchError(
                f"the BNO055 at {address:#04x} stopped answering ({error}); check wiring"
            ) from None
        self.findings["imu"] = {"address": address, **reading.as_dict()}
        self._say(
            f"BNO055 at {address:#04x}: heading {reading.heading_deg:.1f} deg, turning"
            f" {reading.gyro_z_deg_s:.1f} deg/s (left is positive), calibration system"
            f" {reading.calibration_system}, gyro {reading.calibration_gyro}, accelerometer"
            f" {reading.calibration_accelerometer} of 3"
        )
        return True


def _name(found: Pot) -> str:
    return f"AD5282 at {found.address:#04x}"
