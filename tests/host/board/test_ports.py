"""Identifies serial ports by their USB ids."""

import pytest
from serial.tools import list_ports
from serial.tools.list_ports_common import ListPortInfo

from gazechair.board import ports


def usb(path: str, vid: int | None, pid: int | None = None, product: str = "") -> ListPortInfo:
    info = ListPortInfo(path)
    info.vid, info.pid, info.product = vid, pid, product
    return info


@pytest.mark.parametrize(
    ("vid", "pid", "role", "words"),
    [
        (0xF055, 0x9802, ports.BOARD, "MicroPython"),
        (0x16C0, 0x0483, ports.BOARD, "Teensy"),
        (0x2341, 0x8036, ports.OTHER, "Leonardo"),
        (0x2A03, 0x8036, ports.OTHER, "Leonardo"),
        (0x10C4, 0xEA60, ports.LIDAR, "RPLIDAR"),
        (0x1A86, 0x7523, ports.OTHER, "unknown device"),
        (None, None, ports.OTHER, "not on USB"),
    ],
)
def test_usb_ids_tell_what_a_port_is(
    vid: int | None, pid: int | None, role: str, words: str
) -> None:
    port = ports.describe(usb("/dev/ttyACM0", vid, pid))
    assert port.role == role
    assert words in port.what


def test_auto_finds_the_board_and_never_offers_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    there = [
        usb("/dev/ttyUSB0", 0x10C4, 0xEA60),
        usb("/dev/ttyACM1", 0xF055, 0x9802),
        usb("/dev/ttyACM0", 0x2341, 0x8036),
        usb("/dev/ttyS0", None),
    ]
    monkeypatch.setattr(list_ports, "comports", lambda: there)
    assert ports.finder("auto", ports.BOARD)() == ["/dev/ttyACM1"]
    assert ports.finder("auto", ports.LIDAR)() == ["/dev/ttyUSB0"]
    del there[1]
    assert ports.finder("auto", ports.BOARD)() == []
    line = ports.nothing_found(ports.BOARD)
    assert "/dev/ttyACM0 is the LattePanda's built-in Leonardo" in line
    assert "\n" not in line


def test_a_device_that_goes_while_ports_are_listed_is_not_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def going() -> None:
        int(None, 16)  # as pyserial does with the id of a device whose files have gone

    monkeypatch.setattr(list_ports, "comports", going)
    assert ports.finder("auto", ports.BOARD)() == []
    assert "there are none" in ports.nothing_found(ports.BOARD)


def test_a_configured_path_passes_as_it_is() -> None:
    assert ports.finder("/run/chair/board", ports.BOARD)() == ["/run/chair/board"]
