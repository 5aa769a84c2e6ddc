"""The USB line between board and host in virtual time, in memory: delay, damage, the plug."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

BOARD_RING = 512  # capacity of the Teensy's USB driver before the line blocks the host
HOST_BUFFER = 4096  # capacity of the kernel for a host that does not read

# Damages a chunk in transit: returns any number of chunks.
Mangle = Callable[[bytes], list[bytes]]


class Lane:
    """One direction. Chunks arrive `delay_ms` after they were sent, in order, unless mangled."""

    def __init__(self, room: int) -> None:
        self._room = room
        self._ready = bytearray()
        self._flying: deque[tuple[int, bytes]] = deque()
        self.delay_ms = 0
        self.mangle: Mangle | None = None
        self.seen: list[bytes] | None = None
        """Everything that was sent, chunk by chunk, when a test sets it to []."""

    def room(self) -> int:
        """Bytes that the line accepts now."""
        taken = len(self._ready)
        for _, chunk in self._flying:
            taken += len(chunk)
        return max(0, self._room - taken)

    def put(self, chunk: bytes, now_ms: int) -> None:
        """Send one chunk."""
        if self.seen is not None:
            self.seen.append(chunk)
        for piece in [chunk] if self.mangle is None else self.mangle(chunk):
            self._flying.append((now_ms + self.delay_ms, piece))

    def inject(self, chunk: bytes) -> None:
        """Insert foreign bytes, which arrive at once."""
        self._ready += chunk

    def advance(self, now_ms: int) -> None:
        """Deliver the chunks that are due."""
        while self._flying and self._flying[0][0] <= now_ms:
            self._ready += self._flying.popleft()[1]

    def take(self, limit: int) -> bytes:
        """At most `limit` bytes that have arrived."""
        if not self._ready:
            return b""
        data = bytes(self._ready[:limit])
        del self._ready[:limit]
        return data

    def take_byte(self) -> int:
        """The next byte that has arrived, -1 when there is none."""
        return self._ready.pop(0) if self._ready else -1

    def clear(self) -> None:
        """Lose all bytes in transit."""
        self._ready.clear()
        self._flying.clear()


class UsbLine:
    """Both lanes and the plug. Pulling it loses all bytes in transit."""

    def __init__(self) -> None:
        self.to_board = Lane(BOARD_RING)
        self.to_host = Lane(HOST_BUFFER)
        self.plugged = True
        self.host_reads = False  # a host has the port open
        self.now_ms = 0

    def pull(self) -> None:
        """Pull the plug: the host's port vanishes."""
        self.plugged = False
        self.to_board.clear()
        self.to_host.clear()

    def plug(self) -> None:
        """Plug it in again."""
        self.plugged = True

    def advance(self, now_ms: int) -> None:
        """Let time pass on the line."""
        self.now_ms = now_ms
        self.to_board.advance(now_ms)
        self.to_host.advance(now_ms)


class BoardEnd:
    """The firmware's serial port. Never waits."""

    def __init__(self, line: UsbLine) -> None:
        self._line = line
        self._gathered = bytearray()

    def read_byte(self) -> int:
        """The next byte, -1 when there is none."""
        return self._line.to_board.take_byte()

    def write_some(self, buf: bytearray, start: int, end: int) -> int:
        """Bytes without a reader are lost; a host that does not read blocks the board's line."""
        line = self._line
        if not (line.plugged and line.host_reads):
            self._gathered.clear()
            return end
        end = min(end, start + max(0, line.to_host.room() - len(self._gathered)))
        self._gathered += buf[start:end]
        return end

    def flush(self) -> None:
        """Called once a millisecond: USB sends the collected bytes."""
        if self._gathered and self._line.plugged:
            self._line.to_host.put(bytes(self._gathered), self._line.now_ms)
        self._gathered.clear()
