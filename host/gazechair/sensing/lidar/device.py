"""The RPLIDAR S2 through rplidar-roboticia, with that library's known faults contained.

The library opens, identifies, checks health, starts and stops; its own stream reader is not used
(it hangs on a stalled stream, and never resynchronises).
"""

from __future__ import annotations

import contextlib
import errno
import os
import select
import struct
import termios
import time

import rplidar
from rplidar import RPLidar, RPLidarException

from gazechair.board.ports import listed
from gazechair.sensing.lidar.dense import CAPSULE_SIZE
from gazechair.sensing.lidar.report import LOST, PROTECTION, SILENT

BAUD = 1_000_000
MODEL_S2 = 0x71
USB_IDS = (0x10C4, 0xEA60)  # the S2's adapter, a CP2102N
SIMULATED_SERIAL = b"SIM"
_MOTOR_RPM = 600
_REPLY_S = 1.0
_MAX_READ = 1 << 16

# The library finds requests and replies by such a table; the dense scan takes a payload.
_SCANS = {"standard": "normal", "dense": "dense"}
rplidar._SCAN_TYPE["dense"] = {
    "byte": b"\x82\x05\x01\x00\x00\x00\x00\x23",
    "response": 0x85,
    "size": CAPSULE_SIZE,
}


class LidarError(Exception):
    """The lidar can't be used; the text is one plain line: what, where, what to do.

    `reason` is a key of the string tables.
    """

    def __init__(self, text: str, reason: str = LOST) -> None:
        super().__init__(text)
        self.reason = reason


def find_port(configured: str) -> str:
    """The port meant by the setting lidar.port. Raises LidarError when it is not there.

    "auto": the only one with the S2's adapter; "usb:SERIAL": the adapter with that serial number.
    """
    wanted = configured.removeprefix("usb:")
    if configured not in ("auto", f"usb:{wanted}"):
        return configured
    adapters = [port for port in listed() if (port.vid, port.pid) == USB_IDS]
    if configured != "auto":
        for adapter in adapters:
            if adapter.serial_number == wanted:
                return str(adapter.device)
        there = ", ".join(f"usb:{adapter.serial_number}" for adapter in adapters) or "none"
        raise LidarError(
            f"no lidar's adapter has serial number {wanted!r}; there is {there}: "
            "check its plug, or set lidar.port"
        )
    found = [adapter.device for adapter in adapters]
    if len(found) == 1:
        return str(found[0])
    if not found:
        raise LidarError(
            f"no lidar found on USB ({USB_IDS[0]:04x}:{USB_IDS[1]:04x}); "
            "check its plug, or set lidar.port"
        )
    raise LidarError(f"several adapters like the lidar's: set lidar.port to one of {found}")


class _Library(RPLidar):  # type: ignore[misc]  # the library has no type hints
    """rplidar-roboticia adapted to an S-series lidar."""

    def start_motor(self) -> None:
        # The library sends the A2's command and sets DTR (the A1's motor), which raises on a pty.
        self._send_payload_cmd(b"\xa8", struct.pack("<H", _MOTOR_RPM))
        self.motor_running = True

    def stop_motor(self) -> None:
        self._send_payload_cmd(b"\xa8", struct.pack("<H", 0))
        self.motor_running = False

    def _read_response(self, dsize: int) -> bytes:
        # The library waits here without limit when the lidar stops sending.
        data: bytes = self._serial.read(dsize)
        if len(data) != dsize:
            raise RPLidarException(f"{len(data)} of {dsize} bytes came")
        return data


class S2:
    """An open, identified S2. Every method ends within about 3 s. Raises LidarError."""

    def __init__(self, port: str) -> None:
        self._port = port
        try:
            self._lidar = _Library(port, BAUD, timeout=_REPLY_S)
        except (RPLidarException, OSError, ValueError) as error:
            raise LidarError(_cannot_open(port, error)) from error
        try:
            try:
                self._lidar._serial.exclusive = True
            except OSError as error:  # pyserial's SerialException is one
                raise LidarError(_in_use(port)) from error
            self._quiet()
            self.serial = self._identify()
        except BaseException:
            self._lidar.disconnect()
            raise

    @property
    def simulated(self) -> bool:
        """True for the simulator's lidar: its serial number begins with "SIM"."""
        return self.serial.startswith(SIMULATED_SERIAL)

    def start(self, mode: str) -> None:
        """Check health, run the motor up and start the scan; `mode`: "dense" or "standard"."""
        try:
            health = self._lidar.get_health()[0]
            if health != "Error":
                self._lidar.start_motor()
                refused = self._lidar.start(_SCANS[mode])
        except (RPLidarException, OSError, KeyError, ValueError) as error:
            # ValueError: the library unpacks its own message about bytes that still arrive.
            raise LidarError(
                f"the lidar at {self._port} does not start: {error}; "
                "check that it turns freely and its power supply",
                SILENT,
            ) from error
        if health == "Error":
            with contextlib.suppress(OSError):
                self._lidar._send_cmd(rplidar.RESET_BYTE)  # ends the protection, if anything does
            raise LidarError(
                f"the lidar at {self._port} does not start: it protects itself; "
                "check that it turns freely and is not hot, then unplug it once",
                PROTECTION,
            )
        if refused:
            raise LidarError(f"the lidar at {self._port} does not start: {refused}")

    def read(self, timeout_s: float) -> bytes:
        """All bytes of the stream that are there, empty after `timeout_s` without any."""
        fd = self._lidar._serial.fileno()
        if not select.select([fd], [], [], timeout_s)[0]:
            return b""
        try:
            data = os.read(fd, _MAX_READ)
        except OSError as error:
            raise LidarError(f"the lidar at {self._port} is gone: {error.strerror}") from error
        if not data:
            raise LidarError(f"the lidar at {self._port} is gone: check its USB plug")
        return data

    def close(self) -> None:
        """Stop the scan and the motor and close the port. Never raises."""
        with contextlib.suppress(Exception):
            self._lidar.stop()
            self._lidar.stop_motor()
        with contextlib.suppress(Exception):
            self._lidar.disconnect()

    def _quiet(self) -> None:
        """Stop whatever an earlier owner left running, and discard what is still arriving."""
        try:
            self._lidar.stop()
            deadline_s = time.monotonic() + _REPLY_S
            while time.monotonic() < deadline_s and self.read(0.05):
                pass
        except (OSError, termios.error) as error:
            raise LidarError(f"the lidar at {self._port} can't be written to: {error}") from error

    def _identify(self) -> bytes:
        try:
            info = self._lidar.get_info()
        except (RPLidarException, OSError) as error:
            raise LidarError(
                f"no RPLIDAR answers at {self._port} ({error}); "
                "check lidar.port in the configuration and the lidar's power",
                SILENT,
            ) from error
        if isinstance(info, str):  # the library's signal that bytes are still arriving
            raise LidarError(
                f"{self._port} sends unasked: another device? check lidar.port in the configuration"
            )
        if info["model"] != MODEL_S2:
            raise LidarError(
                f"the lidar at {self._port} is model 0x{info['model']:02x}, not an S2 "
                f"(0x{MODEL_S2:02x}); connect an S2 or correct lidar.port"
            )
        return bytes.fromhex(info["serialnumber"])


def _in_use(port: str) -> str:
    return f"the lidar's port {port} is used by another program; end that one"


def _cannot_open(port: str, error: Exception) -> str:
    cause = error.__context__ if error.__context__ is not None else error
    number = getattr(cause, "errno", None)
    if number == errno.EACCES:
        return f"no permission to open the lidar at {port}; add your user to group dialout"
    if number == errno.ENOENT or not os.path.exists(port):
        return f"there is no port {port}; check the lidar's USB plug and lidar.port"
    if number == errno.EBUSY:
        return _in_use(port)
    return f"the lidar's port {port} can't be opened: {cause}"
