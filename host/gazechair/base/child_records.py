"""Records that a child process writes to its standard output, and their reader.

A record is the length of what follows (u32, little-endian), kind (one byte), payload. Kind "S" is a
status, JSON {"state", "reason", "detail"}; kind "D" is the newest value, of which the parent keeps
only the newest; kind "F" are facts about the child itself.
"""

from __future__ import annotations

import json
import os
import struct

STATUS = b"S"
DATA = b"D"
FACTS = b"F"
MAX_RECORD = 1 << 20
_HEADER = struct.Struct("<I")


class RecordReader:
    """Cuts a child's byte stream into records of at most `longest` bytes."""

    def __init__(self, longest: int = MAX_RECORD) -> None:
        self._buffer = bytearray()
        self._longest = longest

    def feed(self, data: bytes) -> list[tuple[bytes, bytes]]:
        """The complete records in `data` and the bytes before it, as (kind, payload).

        Raises ValueError for a length out of range.
        """
        self._buffer += data
        records = []
        while len(self._buffer) >= _HEADER.size:
            (length,) = _HEADER.unpack_from(self._buffer)
            if not 1 <= length <= self._longest:
                raise ValueError(f"record of {length} bytes")
            end = _HEADER.size + length
            if len(self._buffer) < end:
                break
            body = bytes(self._buffer[_HEADER.size : end])
            records.append((body[:1], body[1:]))
            del self._buffer[:end]
        return records


class RecordWriter:
    """The child's side: writes whole records to a file descriptor; raises BrokenPipeError."""

    def __init__(self, fd: int) -> None:
        self._fd = fd

    def data(self, payload: bytes) -> None:
        """Send the newest value."""
        self._write(DATA + payload)

    def status(self, state: str, reason: str, detail: str) -> None:
        """Send a status."""
        text = json.dumps({"state": state, "reason": reason, "detail": detail})
        self._write(STATUS + text.encode())

    def facts(self, payload: bytes) -> None:
        """Send facts about this child itself to the parent."""
        self._write(FACTS + payload)

    def _write(self, body: bytes) -> None:
        left = memoryview(_HEADER.pack(len(body)) + body)
        while left:
            left = left[os.write(self._fd, left) :]
