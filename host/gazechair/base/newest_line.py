"""Reads a parent's messages on a child's standard input: only the newest line counts."""

from __future__ import annotations

import os

_CHUNK = 1 << 16


class NewestLine:
    """The newest of the lines on a file descriptor."""

    def __init__(self, fd: int = 0) -> None:
        self._fd = fd
        self._rest = b""

    def read(self) -> bytes | None:
        """The newest whole line, None: none yet. BrokenPipeError: the parent has gone."""
        data = os.read(self._fd, _CHUNK)
        if not data:
            raise BrokenPipeError
        *lines, self._rest = (self._rest + data).split(b"\n")
        return lines[-1] if lines else None
