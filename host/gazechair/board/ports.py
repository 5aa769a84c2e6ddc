"""Classifies this machine's serial ports: board, lidar or neither."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

AUTO = "auto"

BOARD = "board"
LIDAR = "lidar"
OTHER = "other"

PERMIT = "run `sudo usermod -aG dialout $USER` and log in again"

# (vendor, product or None for any, role, what it is). Only role BOARD is ever opened as the board:
# opening a foreign device can reset it, and a lidar's motor would start.
KNOWN: tuple[tuple[int, int | None, str, str], ...] = (
    (0xF055, 0x9802, BOARD, "Teensy with MicroPython"),
    (0xF055, None, BOARD, "board with MicroPython"),
    (0x16C0, None, BOARD, "Teensy with PJRC's USB ids"),
    (0x2341, 0x8036, OTHER, "the LattePanda's built-in Leonardo"),
    (0x2341, None, OTHER, "an Arduino"),
    (0x2A03, 0x8036, OTHER, "the LattePanda's built-in Leonardo"),
    (0x2A03, None, OTHER, "an Arduino"),
    (0x10C4, 0xEA60, LIDAR, "CP2102N, as the RPLIDAR has"),
)


@dataclass(frozen=True)
class Port:
    """One serial port."""

    path: str
    role: str
    """BOARD, LIDAR or OTHER: what it may be opened as."""
    what: str
    """What it is, in plain words."""
    usb_id: str
    """Vendor and product as f055:9802; empty for a port that is not on USB."""
    serial_number: str


PortFinder = Callable[[], list[str]]


def listed() -> list[ListPortInfo]:
    """All serial ports of this machine, as pyserial lists them; none while one is being unplugged.

    pyserial 3.5 reads a device's files one after the other, and fails when they go meanwhile.
    """
    try:
        return list(list_ports.comports())
    except (OSError, TypeError, ValueError):
        return []


def seen() -> list[Port]:
    """All serial ports of this machine, by path."""
    return sorted(map(describe, listed()), key=lambda port: port.path)


def describe(info: ListPortInfo) -> Port:
    """What one port listed by pyserial is."""
    number = info.serial_number or ""
    if info.vid is None:
        return Port(info.device, OTHER, "not on USB", "", number)
    usb_id = f"{info.vid:04x}:{info.pid:04x}"
    for vendor, product, role, what in KNOWN:
        if info.vid == vendor and product in (None, info.pid):
            return Port(info.device, role, what, usb_id, number)
    return Port(info.device, OTHER, info.product or "unknown device", usb_id, number)


def finder(configured: str, role: str) -> PortFinder:
    """A function that lists the paths to try, best first; [] when there is none.

    A configured path (also a symlink or a pseudo terminal) passes unchanged; AUTO searches for
    ports of `role` by USB ids at each call, so that any order of plugging in works.
    """
    if configured != AUTO:
        return lambda: [configured]
    return lambda: [port.path for port in seen() if port.role == role]


def nothing_found(role: str) -> str:
    """One plain line for an empty search: what was looked for, what is there, what to do."""
    there = "; ".join(f"{port.path} is {port.what}" for port in seen() if port.usb_id)
    return (
        f"no {role} found among the USB serial ports ({there or 'there are none'});"
        f" plug it in, or set [{role}] port in the configuration"
    )
