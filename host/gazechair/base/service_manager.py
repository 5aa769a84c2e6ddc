"""Notifies systemd that the daemon is ready, alive or ending (sd_notify(3)); else does nothing."""

from __future__ import annotations

import contextlib
import os
import socket


class ServiceManager:
    """systemd, when it started this process as a service of `Type=notify`."""

    def __init__(self) -> None:
        address = os.environ.pop("NOTIFY_SOCKET", "")  # not for child processes
        self._address = "\0" + address[1:] if address.startswith("@") else address
        watchdog_us = os.environ.pop("WATCHDOG_USEC", "")
        self.pace_s = min(1.0, int(watchdog_us) / 2e6) if watchdog_us.isdecimal() else 1.0
        """How often to call `alive`, so that a single late call does not end the service."""

    def ready(self, status: str) -> None:
        """Every part has been started."""
        self._notify(f"READY=1\nSTATUS={status}")

    def alive(self) -> None:
        """Restart the watchdog's time."""
        self._notify("WATCHDOG=1")

    def ending(self) -> None:
        """The daemon stops."""
        self._notify("STOPPING=1")

    def _notify(self, text: str) -> None:
        if not self._address:
            return
        kind = socket.SOCK_DGRAM | socket.SOCK_NONBLOCK
        # If systemd does not receive this, its watchdog ends the service.
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, kind) as line:
            line.sendto(text.encode(), self._address)
