"""The newest picture for other processes, in shared memory; nothing is ever queued.

One process writes, others with the descriptor read. Two buffers are written in turn: a reader that
was overtaken twice gets no picture, and tries again.
"""

from __future__ import annotations

import os
import struct
import zlib
from dataclasses import dataclass

from gazechair.picture.camera.mjpeg import MAX_JPEG

_HEAD = struct.Struct("<QdII")  # number, acquired, bytes, checksum
_PLACE = _HEAD.size + MAX_JPEG
_PLACES = 2


@dataclass(frozen=True)
class Shot:
    """A JPEG and the time it was taken (CLOCK_MONOTONIC, s)."""

    jpeg: bytes
    acquired_s: float


class LatestPicture:
    """The writer's side; one thread at a time."""

    def __init__(self) -> None:
        self._fd = os.memfd_create("pictures", os.MFD_CLOEXEC)
        os.ftruncate(self._fd, _PLACES * _PLACE)
        # Readers must not write.
        self.fd = os.open(f"/proc/self/fd/{self._fd}", os.O_RDONLY | os.O_CLOEXEC)
        """For readers."""
        self._number = 0

    def put(self, jpeg: bytes, acquired_s: float) -> None:
        """Replace the picture before the last. One that is too large is dropped."""
        if len(jpeg) > MAX_JPEG:
            return
        self._number += 1
        at = self._number % _PLACES * _PLACE
        os.pwrite(self._fd, jpeg, at + _HEAD.size)
        head = self._number, acquired_s, len(jpeg), zlib.crc32(jpeg)
        os.pwrite(self._fd, _HEAD.pack(*head), at)

    def close(self) -> None:
        """Close this side; readers keep their mapping."""
        os.close(self.fd)
        os.close(self._fd)


class PictureReader:
    """The reader's side."""

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._number = 0

    def take(self) -> Shot | None:
        """The newest; None: none, or none since the last call."""
        for at in range(0, _PLACES * _PLACE, _PLACE):
            number, acquired_s, size, checksum = self._head(at)
            if number <= self._number or number < self._head((at + _PLACE) % (_PLACES * _PLACE))[0]:
                continue
            jpeg = os.pread(self._fd, min(size, MAX_JPEG), at + _HEAD.size)
            if zlib.crc32(jpeg) == checksum:
                self._number = number
                return Shot(jpeg, acquired_s)
        return None

    def _head(self, at: int) -> tuple[int, float, int, int]:
        head = os.pread(self._fd, _HEAD.size, at)
        number, acquired_s, size, checksum = _HEAD.unpack(head)
        return number, acquired_s, size, checksum
