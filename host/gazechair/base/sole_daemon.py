"""The lock of a state folder: one daemon at a time uses it."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
from collections.abc import Iterator
from pathlib import Path

from gazechair.base.user_error import UserError

LOCK_NAME = "lock"  # kept by the daemon as long as it runs, even while it hangs

log = logging.getLogger(__name__)


class AlreadyRunning(UserError):
    """Raised when another daemon uses that state folder."""


@contextlib.contextmanager
def sole_daemon(folder: Path) -> Iterator[None]:
    """Keep the state folder, created if missing, from other daemons meanwhile.

    Raises AlreadyRunning; a folder that cannot be written is only logged. To be entered before the
    folder is read: what the daemon before writes at its end must not be missed.
    """
    lock, free = -1, True
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = os.open(folder / LOCK_NAME, os.O_RDWR | os.O_CREAT, 0o600)
        free = _locked(lock)
    except OSError as error:
        log.warning("%s: %s; another daemon would not be noticed", folder, error)
    try:
        if not free:
            raise AlreadyRunning(
                f"another gazechair runs with the state folder {folder}; "
                "end it, or give this one its own web.state_folder"
            )
        yield
    finally:
        if lock >= 0:
            os.close(lock)


@contextlib.contextmanager
def no_daemon(folder: Path) -> Iterator[None]:
    """Keep the state folder from any daemon meanwhile.

    Raises AlreadyRunning when a daemon has it, even one that does not answer; OSError when this
    cannot be determined.
    """
    try:
        # Not created: a lock that root owns would be of no use to the daemon's user.
        lock = os.open(folder / LOCK_NAME, os.O_RDONLY)
    except FileNotFoundError:
        yield  # no daemon ever ran here
        return
    try:
        if not _locked(lock):
            raise AlreadyRunning(f"a gazechair run has the state folder {folder}")
        yield
    finally:
        os.close(lock)


def _locked(lock: int) -> bool:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
