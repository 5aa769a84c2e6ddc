"""The USB cable between the board's serial line and the host's port; it can be pulled."""

from __future__ import annotations

import contextlib
import os
import random
import select
import threading
import time
import tty
from collections import deque
from pathlib import Path

from gazesim.pty_port import PtyPort

_CHUNK = 512  # bytes moved at a time: the Teensy's receive ring
_WAITING_LIMIT = 4096  # bytes in transit before the sender must wait
_LOOK_S = 0.02  # how often to look whether the host opened the port
_GATHER_S = 0.001  # the board writes byte by byte; USB too carries what has gathered


class _Lane:
    """One direction of the cable: damage, delay, and back-pressure."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._waiting: deque[tuple[float, bytes]] = deque()
        self._size = 0
        self.corrupt = 0.0
        self.drop = 0.0
        self.duplicate = 0.0
        self.delay_s = 0.0

    @property
    def full(self) -> bool:
        """Whether no more should be read from the sender."""
        return self._size >= _WAITING_LIMIT

    def clear(self) -> None:
        """Discard what is in transit."""
        self._waiting.clear()
        self._size = 0

    def put(self, data: bytes, now_s: float) -> None:
        """Take bytes from the sender."""
        if self.corrupt or self.drop or self.duplicate:
            data = self._damage(data)
        if data:
            self._waiting.append((now_s + self.delay_s, data))
            self._size += len(data)

    def _damage(self, data: bytes) -> bytes:
        chance = self._random.random
        damaged = bytearray()
        for byte in data:
            if chance() < self.drop:
                continue
            if chance() < self.corrupt:
                byte ^= self._random.randrange(1, 256)
            damaged.append(byte)
            if chance() < self.duplicate:
                damaged.append(byte)
        return bytes(damaged)

    def due(self, now_s: float) -> bytes:
        """The next bytes to deliver, empty when none is due."""
        return self._waiting[0][1] if self._waiting and self._waiting[0][0] <= now_s else b""

    def delivered(self, count: int) -> None:
        """The first `count` bytes of `due` have been delivered."""
        due_s, data = self._waiting.popleft()
        self._size -= count
        if count < len(data):
            self._waiting.appendleft((due_s, data[count:]))

    def wait_s(self, now_s: float) -> float | None:
        """Seconds until something is due; None when nothing is in transit."""
        return max(0.0, self._waiting[0][0] - now_s) if self._waiting else None


class Cable:
    """Moves bytes between the board's descriptor and the host's port `path` in a thread of its own.

    `start` plugs it in. The board's end may be replaced while it runs (a board that restarts).
    """

    def __init__(self, path: str | os.PathLike[str], seed: int = 1) -> None:
        self.port = PtyPort(path)
        self._lock = threading.Lock()
        self._board = -1
        self.to_host = _Lane(seed)
        self.to_board = _Lane(seed + 1)
        self._wake_read, self._wake_write = os.pipe()
        os.set_blocking(self._wake_write, False)
        self._gather_until_s = 0.0
        self._stopping = False
        self._thread = threading.Thread(target=self._run, name="cable", daemon=True)

    def start(self) -> None:
        """Plug it in and start to move bytes."""
        self.plug()
        self._thread.start()

    def stop(self) -> None:
        """Pull it and end the thread; the board's descriptor stays its owner's."""
        self._stopping = True
        self._wake()
        if self._thread.is_alive():
            self._thread.join(timeout=5.0)
        self.pull()
        os.close(self._wake_read)
        os.close(self._wake_write)

    def connect_board(self, fd: int) -> None:
        """Join the board's end: a socket or pty, the caller's; -1 for a board without power."""
        if fd >= 0:
            os.set_blocking(fd, False)
        with self._lock:
            self._board = fd
            self.to_host.clear()
            self.to_board.clear()
        self._wake()

    def connect_tty(self, path: str | os.PathLike[str]) -> int:
        """Join a board behind a terminal (the emulated Teensy's pty); returns the descriptor."""
        fd = os.open(Path(path), os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(fd)
        self.connect_board(fd)
        return fd

    def pull(self) -> None:
        """Pull the plug: the host's port vanishes at once, bytes in transit are lost."""
        with self._lock:
            self.port.unplug()
            self.to_host.clear()
            self.to_board.clear()
        self._wake()

    def plug(self) -> None:
        """Plug it in again: the port reappears under the same path."""
        with self._lock:
            self.port.plug()
        self._wake()

    def host_open(self) -> bool:
        """Whether the host has its port open now."""
        with self._lock:
            return self.port.host_open()

    def set_damage(
        self,
        corrupt: float = 0.0,
        drop: float = 0.0,
        duplicate: float = 0.0,
        delay_ms: float = 0.0,
    ) -> None:
        """Damage both directions: shares of bytes (0..1), and a delay; without arguments, none."""
        for share in (corrupt, drop, duplicate):
            if not 0.0 <= share <= 1.0:
                raise ValueError(f"share = {share} is not within 0..1")
        if not 0.0 <= delay_ms <= 10_000.0:
            raise ValueError(f"delay_ms = {delay_ms} is not within 0..10000")
        for lane in (self.to_host, self.to_board):
            lane.corrupt, lane.drop, lane.duplicate = corrupt, drop, duplicate
            lane.delay_s = delay_ms / 1000.0
        self._wake()

    def _wake(self) -> None:
        with contextlib.suppress(BlockingIOError):  # a full pipe wakes as well
            os.write(self._wake_write, b"w")

    def _run(self) -> None:
        while not self._stopping:
            poll = select.poll()
            poll.register(self._wake_read, select.POLLIN)
            with self._lock:
                timeout_s = self._watch(poll)
            ready = {fd for fd, _ in poll.poll(None if timeout_s is None else timeout_s * 1000.0)}
            if self._wake_read in ready:
                os.read(self._wake_read, 4096)
            with self._lock:
                self._move()

    def _watch(self, poll: select.poll) -> float | None:
        """Register what to wait for; returns how long at most, in seconds."""
        now_s = time.monotonic()
        waits = [wait for lane in (self.to_host, self.to_board) if (wait := lane.wait_s(now_s))]
        open_now = self.port.host_open()
        if open_now:
            wanted = 0 if self.to_board.full else select.POLLIN
            wanted |= select.POLLOUT if self.to_host.due(now_s) else 0
            poll.register(self.port.fileno(), wanted)
        elif self.port.plugged:
            waits.append(_LOOK_S)
        if self._board >= 0:
            gather_s = self._gather_until_s - now_s
            if gather_s > 0.0:
                waits.append(gather_s)
            wanted = 0 if self.to_host.full or gather_s > 0.0 else select.POLLIN
            wanted |= select.POLLOUT if self.to_board.due(now_s) else 0
            if wanted:
                poll.register(self._board, wanted)
        return min(waits) if waits else None

    def _move(self) -> None:
        if not self.to_board.full and (data := self.port.read(_CHUNK)):
            self.to_board.put(data, time.monotonic())
        now_s = time.monotonic()
        gathered = now_s >= self._gather_until_s and not self.to_host.full
        if self._board >= 0 and gathered and (data := self._read_board()):
            self.to_host.put(data, now_s)
            self._gather_until_s = now_s + _GATHER_S
        while data := self.to_host.due(now_s):
            count = self.port.write(data)  # without a listener all of it is lost
            if not count:
                break
            self.to_host.delivered(count)
        while self._board >= 0 and (data := self.to_board.due(now_s)):
            count = self._write_board(data)
            if not count:
                break
            self.to_board.delivered(count)

    def _read_board(self) -> bytes:
        try:
            data = os.read(self._board, _CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:  # the board's process has ended; its next one will be connected again
            self._board = -1
        return data

    def _write_board(self, data: bytes) -> int:
        try:
            return os.write(self._board, data)
        except BlockingIOError:
            return 0
        except OSError:
            self._board = -1
            return 0
