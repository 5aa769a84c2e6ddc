"""docs/wiring.md says what the firmware does: pins, buses, wiper counts, LED patterns."""

import re
from pathlib import Path

from gazeboard import app
from gazeboard.boards import pins
from gazeboard.core import limits
from gazeboard.io import joystick
from gazechair.service.bench import pot

TEXT = (Path(__file__).resolve().parents[2] / "docs" / "wiring.md").read_text()
ROWS = dict(re.findall(r"^\| (D\d+(?:, D\d+)?) \| (\w+(?: \d)?) \|", TEXT, re.MULTILINE))


def test_its_table_of_pins_is_the_firmwares() -> None:
    names = {"ENABLE", "RELAY_FEEDBACK", "EMERGENCY", "BUTTON", "LED"}
    expected = {f"D{getattr(pins, name)}": name for name in names}
    expected["D18, D19"] = f"JOYSTICK_BUS {pins.JOYSTICK_BUS}"
    expected["D17, D16"] = f"IMU_BUS {pins.IMU_BUS}"
    assert expected == ROWS


def test_its_pins_are_all_the_firmware_has() -> None:
    numbers = {name for name in vars(pins) if name.isupper() and not name.endswith(("_US", "_HZ"))}
    assert numbers == {name.split()[0] for name in ROWS.values()}


def test_its_counts_and_addresses_are_the_firmwares() -> None:
    assert f"Counts {limits.WIPER_MIN}..{limits.WIPER_MAX}" in TEXT
    assert f"{limits.WIPER_NEUTRAL} is neutral" in TEXT
    assert f"AD5282 ({joystick.ADDRESS:#04X})".replace("0X", "0x") in TEXT
    assert (pot.LOWEST, pot.NEUTRAL, pot.HIGHEST) == (
        limits.WIPER_MIN,
        limits.WIPER_NEUTRAL,
        limits.WIPER_MAX,
    )


def test_its_led_table_is_the_firmwares() -> None:
    assert app._LED_NO_HOST == (50, 2000)
    assert "50 ms every 2 s | no host" in TEXT
    assert app._LED_DISARMED == (500, 1000)
    assert "0.5 s on, 0.5 s off | disarmed" in TEXT
    assert app._LED_ARMED == (1000, 1000)
    assert "| on | arming or armed" in TEXT
    assert app._LED_FAULT == (100, 200)
    assert "0.1 s on, 0.1 s off | a fault" in TEXT


def test_its_relay_times_are_the_firmwares() -> None:
    assert f"within {limits.RELAY_CLOSE_MS} ms and for {limits.RELAY_HOLD_MS} ms" in TEXT
    assert limits.RESET_PRESS_MS == 3000
    assert "3 s resets latched faults" in TEXT
