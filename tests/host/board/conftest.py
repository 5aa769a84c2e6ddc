"""The link's protocol and a fake board, joined without loss, in virtual time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from gazechair.board.events import Event
from gazechair.board.protocol import LinkProtocol


class Line:
    """A protocol and a board joined without loss; only the test advances time."""

    def __init__(self, board: Any) -> None:
        self.board = board
        self.now_s = 100.0
        self.protocol = LinkProtocol()
        self.protocol.opened(self.now_s)
        self.events: list[Event] = []

    def turn(self, ms: int = 0) -> list[Event]:
        """Let `ms` pass, polling each millisecond; the events of that time."""
        new: list[Event] = []
        for step in range(ms + 1):
            if step:
                self.now_s += 0.001
                self.board.stamp_ms = (self.board.stamp_ms + 1) & 0xFFFF
            answer = self.board.receive(self.protocol.poll(self.now_s))
            if step % 10 == 0 and self.board.session:
                answer += self.board.state()
            new += self.protocol.feed(answer, self.now_s)
            new += self.protocol.check(self.now_s)
        self.events += new
        return new

    def say(self, data: bytes) -> list[Event]:
        """The board sends `data`."""
        return self.protocol.feed(data, self.now_s)


@pytest.fixture
def line(board: Any) -> Line:
    return Line(board)


@pytest.fixture
def joined(line: Line) -> Line:
    line.turn()
    assert line.protocol.board is not None
    line.board.received.clear()
    return line


@pytest.fixture(scope="session")
def new_line(new_board: Callable[[], Any]) -> Callable[[], Line]:
    """A maker of lines, each with a board of its own."""
    return lambda: Line(new_board())
