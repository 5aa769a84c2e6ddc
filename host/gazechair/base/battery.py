"""The charge of the computer's own battery, where it has one."""

from __future__ import annotations

from pathlib import Path

SUPPLIES = Path("/sys/class/power_supply")


def charge_percent(supplies: Path = SUPPLIES) -> int | None:
    """0..100; None without a battery, or when it does not tell.

    A mouse or a phone that reports a battery of its own has `scope` Device and does not count
    (Linux kernel, Documentation/ABI/testing/sysfs-class-power). Of several, the emptiest.
    """
    found = []
    for folder in sorted(supplies.glob("*")):
        if _word(folder / "type") == "Battery" and _word(folder / "scope") != "Device":
            word = _word(folder / "capacity")
            if word.isdecimal() and int(word) <= 100:
                found.append(int(word))
    return min(found, default=None)


def _word(file: Path) -> str:
    try:
        return file.read_text().strip()
    except (OSError, UnicodeDecodeError):  # it was unplugged, or has no such file
        return ""
