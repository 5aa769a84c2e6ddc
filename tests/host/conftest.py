"""A board on the other end of the wire, honest unless told otherwise, for the link's tests."""

from __future__ import annotations

import contextlib
import os
import select
import threading
import tty
from collections.abc import Callable, Iterator
from dataclasses import astuple
from pathlib import Path
from typing import Any

import pytest

from gazelink import VERSION, codes, frame, messages
from gazesim.board_limits import LIMITS

BOOT = 0x0B07


class FakeBoard:
    """Answers HELLO and PING like the firmware; the rest is sent when the test says so."""

    def __init__(self) -> None:
        self.boot = BOOT
        self.session = 0
        self.schema_hash = frame.schema_hash()
        self.stamp_ms = 1000
        self.flags = 0
        self.limits = LIMITS
        self.status = codes.DISARMED
        self.received: list[tuple[str, dict[str, Any]]] = []
        self.stamps: list[int] = []
        self._decoder = frame.Decoder()
        self._encoder = frame.Encoder()
        self._keys = frame.Session()
        self._decoder.session = self._encoder.session = self._keys
        self.nonce = b"fake"

    def receive(self, data: bytes) -> bytes:
        """Take bytes from the host; the bytes with which the board answers at once."""
        answer = b""
        for byte in data:
            if self._decoder.feed(byte):
                answer += self._on_frame(self._decoder.buf)
        return answer

    def hello(self) -> bytes:
        values = (1, self.flags, self.schema_hash, self.session, self.boot, *VERSION, b"fake")
        return self._frame(messages.HELLO, values)

    def nonce_frame(self) -> bytes:
        values = (self.session, self.nonce, self._keys.epoch)
        return self._frame(messages.NONCE, values)

    def limits_frame(self) -> bytes:
        return self._frame(messages.LIMITS, astuple(self.limits))

    def state(self, **changes: int) -> bytes:
        values = dict.fromkeys(messages.STATE.names, 0) | {"status": self.status}
        return self._frame(messages.STATE, tuple((values | changes).values()))

    def stats(self, **changes: int) -> bytes:
        values = dict.fromkeys(messages.STATS.names, 0) | changes
        return self._frame(messages.STATS, tuple(values.values()))

    def fault(self, reason: int, detail: bytes) -> bytes:
        return self._frame(messages.FAULT, (reason, detail))

    def setting_reply(self, **changes: int) -> bytes:
        values = dict.fromkeys(messages.SETTING_REPLY.names, 0) | changes
        return self._frame(messages.SETTING_REPLY, tuple(values.values()))

    def zone(self, direction: int, points: bytes) -> bytes:
        return self._frame(messages.ZONE, (direction, points))

    def restart(self) -> None:
        """A reset: another boot id, no session."""
        self.boot = (self.boot + 1) & 0xFFFF
        self.session = 0
        self._keys.end()

    def take(self, name: str) -> list[dict[str, Any]]:
        """The messages of this name heard since the last call of take or forget."""
        found = [fields for kind, fields in self.received if kind == name]
        self.received.clear()
        return found

    def _on_frame(self, buf: bytearray) -> bytes:
        message = messages.BY_TYPE[buf[messages.TYPE_AT]]
        fields = message.unpack(buf)
        self.received.append((message.name, fields))
        self.stamps.append(frame.u16(buf, messages.STAMP_AT))
        if message is messages.HELLO:
            if fields["schema_hash"] == self.schema_hash:
                if fields["session"] != self.session:
                    self.session = fields["session"]
                    self.nonce = bytes([self.nonce[0] + 1 & 0xFF, *self.nonce[1:]])
                    self._keys.begin(self.session, self.boot, self.nonce, 0, self.stamp_ms)
                return self.hello() + self.nonce_frame() + self.limits_frame()
            return self.hello()
        if message is messages.PING:
            return self._frame(messages.PONG, (fields["token_low"], fields["token_high"]))
        return b""

    def _frame(self, message: messages.Message, values: tuple[Any, ...]) -> bytes:
        message.pack(self._encoder.body, values)
        self._keys.advance(self.stamp_ms)
        size = self._encoder.finish(message, self.stamp_ms)
        return bytes(self._encoder.wire[:size])


class Cable:
    """A fake board on a pty behind a symlink; the thread answers and sends STATE."""

    def __init__(self, board: Any, link_path: Path) -> None:
        self.board = board
        self.path = link_path
        self.reading = True
        self.telling = True
        self.state: dict[str, int] = {}
        self._master = -1
        self._ending = threading.Event()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._run, name="fake-board")
        self.plug()
        self._thread.start()

    def plug(self) -> None:
        with self._lock:
            self._master, slave = os.openpty()
            tty.setraw(slave)
            os.set_blocking(self._master, False)
            fresh = self.path.with_suffix(".new")
            fresh.symlink_to(os.ttyname(slave))
            fresh.rename(self.path)
            self._slave = slave  # kept open, so that the line survives without a host

    def pull(self) -> None:
        with self._lock:
            self.path.unlink()
            os.close(self._slave)
            os.close(self._master)
            self._master = -1

    def say(self, data: bytes) -> None:
        with self._lock:
            if self._master >= 0:
                with contextlib.suppress(OSError):  # nobody listens
                    os.write(self._master, data)

    def received(self, name: str) -> list[dict[str, Any]]:
        with self._lock:
            return [fields for kind, fields in list(self.board.received) if kind == name]

    def close(self) -> None:
        self._ending.set()
        self._thread.join(30)
        if self._master >= 0:
            self.pull()

    def _run(self) -> None:
        while not self._ending.wait(0.005):
            with self._lock:
                answer = b""
                if self._master >= 0 and self.reading:
                    ready = select.select([self._master], [], [], 0)[0]
                    try:
                        data = os.read(self._master, 4096) if ready else b""
                    except OSError:
                        data = b""
                    answer = self.board.receive(data)
                self.board.stamp_ms = (self.board.stamp_ms + 5) & 0xFFFF
                if self.board.session and self.telling:
                    answer += self.board.state(**self.state)
            if answer:
                self.say(answer)


@pytest.fixture(scope="session")
def new_board() -> Callable[[], FakeBoard]:
    """A maker of fake boards."""
    return FakeBoard


@pytest.fixture
def board() -> FakeBoard:
    """One fake board."""
    return FakeBoard()


@pytest.fixture(scope="session")
def new_cable() -> Callable[..., Cable]:
    """A maker of cables: board, path of the symlink to its port."""
    return Cable


@pytest.fixture
def cable(board: Any, tmp_path: Path) -> Iterator[Cable]:
    cable = Cable(board, tmp_path / "board")
    yield cable
    cable.close()
