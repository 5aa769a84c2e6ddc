"""One open serial port that never blocks: raw bytes in and out, errors as one line of text."""

from __future__ import annotations

import contextlib
import errno
import os
import termios

import serial

from gazechair.board.ports import PERMIT

# Means nothing on USB and pseudo terminals. Never 1200: it resets boards into their bootloader.
_BAUD = 115200
_READ_SIZE = 1024


class PortError(Exception):
    """The port cannot be opened or has vanished; the text is one plain line."""


class SerialPort:
    """A serial port, USB or pseudo terminal, opened for this process alone."""

    def __init__(self, path: str) -> None:
        """Open `path`. Raises PortError with the reason and what to do."""
        self.path = path
        try:
            self._serial = serial.Serial(
                path, _BAUD, timeout=0, write_timeout=0, exclusive=True, dsrdtr=False
            )
        except (OSError, ValueError, termios.error) as error:
            raise PortError(_why(path, error)) from None
        self._fd: int = self._serial.fileno()

    def fileno(self) -> int:
        """For select and poll."""
        return self._fd

    def read(self) -> bytes:
        """What has arrived, b"" when nothing has. Raises PortError when the port has vanished."""
        try:
            data = os.read(self._fd, _READ_SIZE)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self._gone(error) from None
        return data

    def write(self, data: bytes) -> int:
        """Hand over as much as fits now; how many bytes that was. Raises PortError as read does."""
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            return 0
        except OSError as error:
            raise self._gone(error) from None

    def close(self) -> None:
        """Close; what is still unsent is dropped, because waiting for it could take 30 s."""
        with contextlib.suppress(OSError, termios.error):
            self._serial.reset_output_buffer()
        with contextlib.suppress(OSError, termios.error):
            self._serial.close()

    def _gone(self, error: OSError) -> PortError:
        return PortError(f"{self.path} has vanished ({os.strerror(error.errno or errno.EIO)})")


def _why(path: str, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number is None and "exclusively lock" in str(error):
        number = errno.EBUSY
    if number == errno.ENOENT:
        return f"{path} is not there; plug the device in"
    if number in (errno.EACCES, errno.EPERM):
        return f"{path} is not permitted to this user; {PERMIT}"
    if number in (errno.EBUSY, errno.EWOULDBLOCK):
        return f"{path} is in use by another program; end that one"
    if number in (errno.EINVAL, errno.EISDIR) or "configure port" in str(error):
        return f"{path} is no serial port; give another one in the configuration"
    return f"{path} cannot be opened ({str(error).splitlines()[0]})"
