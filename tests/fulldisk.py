"""A full disk, in place of any function that writes."""

from __future__ import annotations

import errno
from typing import NoReturn


def full(*_: object, **__: object) -> NoReturn:
    """Raises what the operating system does when the disk is full."""
    raise OSError(errno.ENOSPC, "No space left on device")
