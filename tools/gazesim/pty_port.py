"""A simulated serial port for the host: a raw pty behind a stable symlink that can vanish."""

from __future__ import annotations

import contextlib
import errno
import os
import select
import tty
from pathlib import Path


class PtyPort:
    """The device's end of a simulated USB serial port; the host opens `path`.

    All calls return at once. While the host does not have it open, written data is lost, as on a
    USB serial port without a listener; while it does not read, writes go short.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self._master = -1
        self._was_open = False
        self._poll = select.poll()

    @property
    def plugged(self) -> bool:
        """Whether the port exists at all."""
        return self._master >= 0

    def fileno(self) -> int:
        """The device's file descriptor, -1 while unplugged."""
        return self._master

    def plug(self) -> None:
        """Let the port appear; nothing happens when it is there already.

        Raises OSError when the system provides no pseudo-terminal.
        """
        if self.plugged:
            return
        try:
            master, slave = os.openpty()
        except OSError as error:
            why = f"no pseudo-terminal for {self.path}: {error}; is /dev/pts mounted?"
            raise OSError(why) from error
        try:
            tty.setraw(slave)
            os.set_blocking(master, False)
            name = os.ttyname(slave)
        finally:
            os.close(slave)
        self._master = master
        self._poll.register(master, select.POLLIN)
        fresh = self.path.with_name(self.path.name + ".new")
        with contextlib.suppress(FileNotFoundError):
            fresh.unlink()
        fresh.symlink_to(name)
        fresh.replace(self.path)

    def unplug(self) -> None:
        """Let the port vanish: a host that has it open gets EIO, and the path is removed."""
        if not self.plugged:
            return
        with contextlib.suppress(FileNotFoundError):
            self.path.unlink()
        self._poll.unregister(self._master)
        os.close(self._master)
        self._master = -1
        self._was_open = False

    def host_open(self) -> bool:
        """Whether the host has the port open now."""
        if not self.plugged:
            return False
        ready = self._poll.poll(0)
        is_open = not (ready and ready[0][1] & select.POLLHUP)
        if self._was_open and not is_open:
            tty.setraw(self._master)  # whatever the last one made of it
        self._was_open = is_open
        return is_open

    def read(self, size: int = 4096) -> bytes:
        """What the host has written, empty when nothing."""
        if not self.plugged:
            return b""
        try:
            return os.read(self._master, size)
        except OSError as error:
            if error.errno in (errno.EIO, errno.EAGAIN):
                return b""
            raise

    def write(self, data: bytes) -> int:
        """Send to the host; returns the bytes consumed: accepted, or lost without a listener."""
        if not self.host_open():
            return len(data)
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0
