"""The record that the camera's child process sends to the daemon: a picture and its time."""

from __future__ import annotations

import struct
from dataclasses import dataclass

# Keys of the string tables.
LOST = "camera_lost"
STARTING = "camera_starting"

_ACQUIRED = struct.Struct("<d")


@dataclass(frozen=True)
class Frame:
    """One picture: a whole JPEG of at most 512 kB and when it was taken (CLOCK_MONOTONIC, s)."""

    jpeg: bytes
    acquired_monotonic: float

    def pack(self) -> bytes:
        """As one record."""
        return _ACQUIRED.pack(self.acquired_monotonic) + self.jpeg

    @classmethod
    def unpack(cls, payload: bytes) -> Frame:
        """From one record."""
        (acquired_s,) = _ACQUIRED.unpack_from(payload)
        return cls(payload[_ACQUIRED.size :], acquired_s)
