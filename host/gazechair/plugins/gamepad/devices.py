"""Sources of gamepad events: a kernel device, a pipe of recorded events, or a rehearsal."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from gazechair.plugins.contract import Unusable
from gazechair.plugins.gamepad.events import ABS, AXES, REPORT, SYN, Range, Y, event

REHEARSAL = "rehearsal"
FOLDER = Path("/dev/input")
_WIDE: Range = (-32768, 32767)
_CHUNK = 24 * 64
_BUTTONS = range(0x120, 0x140)  # joysticks and gamepads; a mouse has others
_KEY = 1


class Pad(Protocol):
    """An open gamepad. Every method raises OSError when it is gone."""

    def fileno(self) -> int: ...
    def ranges(self) -> dict[int, Range]: ...
    def positions(self) -> dict[int, int]: ...
    def read(self, now_s: float) -> bytes: ...
    def close(self) -> None: ...


class EvdevPad:
    """A kernel device, read through the package evdev."""

    def __init__(self, device: Any) -> None:
        self._device = device

    def fileno(self) -> int:
        """Readable when there are events."""
        return int(self._device.fd)

    def _info(self) -> dict[int, Any]:
        known = dict(self._device.capabilities(absinfo=True).get(ABS, ()))
        return {axis: self._device.absinfo(axis) for axis in AXES if axis in known}

    def ranges(self) -> dict[int, Range]:
        """As reported by the kernel."""
        return {axis: (int(info.min), int(info.max)) for axis, info in self._info().items()}

    def positions(self) -> dict[int, int]:
        """The present position of every axis."""
        return {axis: int(info.value) for axis, info in self._info().items()}

    def read(self, _now_s: float) -> bytes:
        """The queued events."""
        return _read(self.fileno())

    def close(self) -> None:
        """Close the device."""
        self._device.close()


class PipePad:
    """Events as bytes from a named pipe: recorded, or from another program."""

    def __init__(self, path: str) -> None:
        self._fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        self._begun = False

    def fileno(self) -> int:
        """Readable when there are events."""
        return self._fd if self._begun else -1

    def ranges(self) -> dict[int, Range]:
        """Those of most gamepads."""
        return {axis: (-1, 1) if axis >= 16 else _WIDE for axis in AXES}

    def positions(self) -> dict[int, int]:
        """Unknown."""
        return {}

    def read(self, _now_s: float) -> bytes:
        """The queued bytes; raises OSError when the writer has left."""
        try:
            data = os.read(self._fd, _CHUNK)
        except BlockingIOError:
            self._begun = True
            return b""
        if not data and self._begun:
            raise OSError("the other end of the pipe has left")
        self._begun = self._begun or bool(data)
        return data

    def close(self) -> None:
        """Close it."""
        os.close(self._fd)


class RehearsalPad(PipePad):
    """A stick that is pushed forward for 0.6 s in every 1.2 s."""

    def __init__(self) -> None:
        pass

    def fileno(self) -> int:
        """There is none."""
        return -1

    def read(self, now_s: float) -> bytes:
        """The present position of the stick."""
        value = _WIDE[0] if now_s % 1.2 >= 0.6 else 0
        return event(ABS, Y, value, now_s) + event(SYN, REPORT, 0, now_s)

    def close(self) -> None:
        """Nothing is open."""


def opener(device: str) -> Callable[[], Pad]:
    """A function that opens the configured `device`, or raises OSError with one plain line.

    Raises Unusable if a needed package is missing.
    """
    if device == REHEARSAL:
        return RehearsalPad
    if device != "auto" and _is_pipe(device):
        return lambda: PipePad(device)
    try:
        import evdev
    except ImportError:
        raise Unusable(
            "a gamepad needs the package evdev: pip install gazechair[gamepad]"
        ) from None
    return lambda: EvdevPad(_find(evdev, device))


def _find(evdev: Any, wanted: str) -> Any:
    paths = sorted(map(str, FOLDER.glob("event*"))) if wanted == "auto" else [wanted]
    refused = ""
    for path in paths:
        try:
            device = evdev.InputDevice(path)
        except PermissionError:
            refused = f"; {path} is not permitted: add this user to the group input"
            continue
        except OSError:
            continue
        known = device.capabilities(absinfo=False)
        if set(known.get(_KEY, ())) & set(_BUTTONS) and {0, 1} <= set(known.get(ABS, ())):
            return device
        device.close()
    raise OSError(f"no gamepad is plugged in{refused}")


def _read(fd: int) -> bytes:
    try:
        return os.read(fd, _CHUNK)
    except BlockingIOError:
        return b""


def _is_pipe(path: str) -> bool:
    try:
        return stat.S_ISFIFO(os.stat(path).st_mode)
    except OSError:
        return False
