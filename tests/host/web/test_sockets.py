"""WebSockets of our own, by frames made here: what RFC 6455 allows comes whole, others end."""

from __future__ import annotations

import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.web.sockets import ARRIVALS_PER_S, MOST_MESSAGE, Arrivals, Ended, WebSocket

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


def frame(
    kind: int, data: bytes = b"", last: bool = True, mask: bytes = b"\x01\x02\x03\x04"
) -> bytes:
    length = len(data)
    if length < 126:
        head = bytes([kind | 0x80 * last, 0x80 | length])
    elif length < 65536:
        head = bytes([kind | 0x80 * last, 0x80 | 126]) + struct.pack(">H", length)
    else:
        head = bytes([kind | 0x80 * last, 0x80 | 127]) + struct.pack(">Q", length)
    return head + mask + bytes(byte ^ mask[at % 4] for at, byte in enumerate(data))


class Line:
    """A connection that brings these pieces and then nothing more."""

    def __init__(self, *pieces: bytes) -> None:
        self.raw: Any = None
        self.pieces = list(pieces)
        self.sent = b""
        self.read = 0

    def receive(self, size: int, limit_s: float) -> bytes | None:
        if not self.pieces:
            return None
        self.read += 1
        piece = self.pieces.pop(0)
        if len(piece) > size:
            self.pieces.insert(0, piece[size:])
        return piece[:size]

    def sendall(self, data: bytes) -> None:
        self.sent += data


def socket_of(*pieces: bytes) -> tuple[WebSocket, Line]:
    line = Line(*pieces)
    return WebSocket(line, Arrivals(lambda: 0.0), clock=lambda: 0.0), line


def close_code(line: Line) -> int:
    """Of the last frame sent, which must be a close frame."""
    at = 0
    while at < len(line.sent):
        kind, length = line.sent[at] & 15, line.sent[at + 1]
        if kind == CLOSE:
            assert at + 2 + length == len(line.sent)
            return int.from_bytes(line.sent[at + 2 : at + 4], "big")
        at += 2 + length
    raise AssertionError("no close frame")


def ends(socket: WebSocket, calls: int = 100_000) -> str:
    for _ in range(calls):
        try:
            socket.receive(1.0)
        except Ended as ended:
            with pytest.raises(Ended):
                socket.receive(1.0)  # and stays so
            return str(ended)
    raise AssertionError("it did not end")


@settings(deadline=None)
@given(st.lists(st.text(max_size=60), min_size=1, max_size=6), st.data())
def test_messages_come_whole_however_they_are_cut(texts: list[str], data: Any) -> None:
    stream = b""
    for text in texts:
        raw = text.encode()
        cuts = sorted(data.draw(st.lists(st.integers(0, len(raw)), max_size=3)))
        parts = [raw[a:b] for a, b in zip([0, *cuts], [*cuts, len(raw)], strict=True)]
        for at, part in enumerate(parts):
            stream += frame(TEXT if at == 0 else 0, part, last=at == len(parts) - 1)
            stream += frame(PING, b"p") if data.draw(st.booleans()) else b""
    size = data.draw(st.integers(1, 40))
    socket, _ = socket_of(*[stream[at : at + size] for at in range(0, len(stream), size)])
    assert [socket.receive(1.0) for _ in texts] == texts
    assert socket.receive(1.0) is None


def test_bytes_stay_bytes() -> None:
    socket, _ = socket_of(frame(BINARY, b"\xff" * 200))
    assert socket.receive(1.0) == b"\xff" * 200


@pytest.mark.parametrize(
    "piece",
    [
        frame(PING),
        frame(PONG, b"x"),
        frame(TEXT, last=False) + frame(0, last=False) * 3,
        frame(TEXT, last=False) + frame(0),
        frame(TEXT, b"{}"),
    ],
)
def test_whatever_comes_counts(piece: bytes) -> None:
    """Pings, their answers, empty fragments, empty messages: 1000 and the socket ends."""
    first, rest = piece, frame(0, last=False) if piece[0] == TEXT else piece
    if frame(0) in piece or piece == frame(TEXT, b"{}"):
        rest = piece
    socket, line = socket_of(first, *[rest * 50] * 200)
    assert ends(socket) == "far too many messages"
    assert close_code(line) == 1008
    assert line.read <= ARRIVALS_PER_S / 50 + 2


def test_single_bytes_count() -> None:
    stream = frame(TEXT, b"x" * 900) * 9
    socket, line = socket_of(*[stream[at : at + 1] for at in range(len(stream))])
    assert ends(socket) == "far too many messages"
    assert line.read <= ARRIVALS_PER_S + 1


def test_all_sockets_of_a_device_count_together() -> None:
    arrivals = Arrivals(lambda: 0.0)
    lines = [Line(*[frame(PING)] * 400) for _ in range(3)]
    sockets = [WebSocket(line, arrivals, clock=lambda: 0.0) for line in lines]
    assert sockets[0].receive(1.0) is None
    assert ends(sockets[1]) == ends(sockets[2]) == "far too many messages"
    assert not arrivals.allow_opening()


def test_a_device_opens_its_sockets_again_a_few_times_a_second() -> None:
    now_s = 0.0
    arrivals = Arrivals(lambda: now_s)
    opened = 0
    for _ in range(10_000):
        now_s += 0.001
        opened += arrivals.allow_opening()
    assert 200 <= opened <= 221  # 20 a second, and as many at once


def test_few_pings_are_answered() -> None:
    socket, line = socket_of(*[frame(PING, b"%03d" % k) for k in range(500)])
    assert socket.receive(1.0) is None
    assert line.sent[:5] == bytes([0x80 | PONG, 3]) + b"000"
    assert len(line.sent) <= 5 * 20  # the rest is not worth an answer


@pytest.mark.parametrize(
    ("stream", "code"),
    [
        (b"\xff" * 50, 1002),
        (b"\x81\x02hi", 1002),  # without a mask
        (frame(3), 1002),
        (frame(11), 1002),
        (frame(TEXT | 0x40, b"x"), 1002),  # an extension's bit
        (frame(0, b"x"), 1002),  # goes on with nothing
        (frame(TEXT, b"x", last=False) + frame(TEXT, b"y"), 1002),
        (frame(PING, b"x" * 126), 1002),
        (frame(PING, b"x", last=False), 1002),
        (frame(TEXT, b"\xff"), 1007),
        (frame(TEXT, b"\xc3", last=False) + frame(0, b"("), 1007),
        (frame(TEXT, b"\xed\xa0\x80"), 1007),  # half a character
        (frame(TEXT, b"x" * (MOST_MESSAGE + 1)), 1009),
        (frame(TEXT, b"x" * 600, last=False) + frame(0, b"x" * 600), 1009),
        (b"\x81\xff" + b"\xff" * 8, 1009),
        (b"\x81\xff" + b"\x7f" + b"\xff" * 7, 1009),
        (frame(CLOSE), 1000),
        (frame(CLOSE, b"\x03"), 1000),
        (frame(CLOSE, b"\x03\xe8bye"), 1000),
    ],
)
def test_what_is_not_allowed_ends_the_socket_with_its_code(stream: bytes, code: int) -> None:
    socket, line = socket_of(stream, frame(TEXT, b"more"))
    ends(socket, 3)
    assert close_code(line) == code


@settings(deadline=None, max_examples=300)
@given(st.lists(st.binary(max_size=200), max_size=20))
def test_any_bytes_are_messages_or_the_end(pieces: list[bytes]) -> None:
    socket, line = socket_of(*[piece for piece in pieces if piece])
    try:
        while line.pieces:
            message = socket.receive(1.0)
            assert message is None or len(message) <= MOST_MESSAGE
    except Ended:
        assert close_code(line) in (1000, 1002, 1007, 1008, 1009)


def test_an_end_of_the_connection_is_the_end() -> None:
    socket, line = socket_of()
    line.receive = lambda size, limit_s: b""  # type: ignore[method-assign]
    with pytest.raises(Ended):
        socket.receive(1.0)


def test_long_messages_are_sent_with_their_length() -> None:
    socket, line = socket_of()
    for length in (125, 126, 65535, 65536):
        line.sent = b""
        socket.send(b"x" * length)
        short = {125: b"\x82\x7d", 126: b"\x82\x7e\x00\x7e", 65535: b"\x82\x7e\xff\xff"}
        head = short.get(length, b"\x82\x7f" + struct.pack(">Q", length))
        assert line.sent == head + b"x" * length


def test_nothing_is_sent_after_the_end() -> None:
    socket, line = socket_of()
    socket.close(1013, "later")
    sent = line.sent
    for act in (lambda: socket.send("x"), lambda: socket.close()):
        with pytest.raises(Ended):
            act()
    assert line.sent == sent
