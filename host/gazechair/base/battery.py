"""Reads the charge of the computer's own battery, if it has one."""

from __future__ import annotations

from pathlib import Path

SUPPLIES = Path("/sys/class/power_supply")


def charge_percent(supplies: Path = SUPPLIES) -> int | None:
    """0..100, of the emptiest battery; None without a battery, or when it reports nothing.

    The battery of a mouse or a phone has `scope` Device and does not count (Linux kernel,
    Documentation/ABI/testing/sysfs-class-power).
    """
    found = []
    for folder in sorted(supplies.glob("*")):
        if _text(folder / "type") == "Battery" and _text(folder / "scope") != "Device":
            text = _text(folder / "capacity")
            if text.isdecimal() and int(text) <= 100:
                found.append(int(text))
    return min(found, default=None)


def _text(file: Path) -> str:
    try:
        return file.read_text().strip()
    except (OSError, UnicodeDecodeError):  # it was unplugged, or has no such file
        return ""
