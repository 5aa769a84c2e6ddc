"""WebSockets with frames made here: what RFC 6455 allows arrives whole; all frames count."""

from __future__ import annotations

import struct
import threading
import time
from typing import Any

import pytest
import simple_websocket
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.web.websocket import (
    ARRIVALS_PER_S,
    LIBRARY_OPTIONS,
    MOST_MESSAGE,
    Arrivals,
    BadHandshake,
    Ended,
    Line,
    WebSocket,
    handshake,
)

REQUEST = {
    "REQUEST_METHOD": "GET",
    "SERVER_PROTOCOL": "HTTP/1.1",
    "HTTP_HOST": "127.0.0.1",
    "HTTP_UPGRADE": "websocket",
    "HTTP_CONNECTION": "keep-alive, Upgrade",
    "HTTP_SEC_WEBSOCKET_VERSION": "13",
    "HTTP_SEC_WEBSOCKET_KEY": "AAAAAAAAAAAAAAAAAAAAAA==",
}
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


class Wire:
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


def socket_of(
    *pieces: bytes, arrivals: Arrivals | None = None, early: bytes = b""
) -> tuple[WebSocket, Wire]:
    wire = Wire(*pieces)
    line = Line(wire, arrivals or Arrivals(lambda: 0.0), early, clock=lambda: 0.0)
    environ = handshake(REQUEST) | {"werkzeug.socket": line}
    socket = WebSocket(simple_websocket.Server(environ, **LIBRARY_OPTIONS))
    assert wire.sent.startswith(b"HTTP/1.1 101 ")
    assert b"\r\nSec-WebSocket-Accept: ICX+Yqv66kxgM0FcWaLWlFLwTAI=\r\n" in wire.sent
    wire.sent = b""
    return socket, wire


def close_code(line: Wire) -> int | None:
    """Of the last frame sent, which must be a close frame."""
    at = 0
    while at < len(line.sent):
        kind, length = line.sent[at] & 15, line.sent[at + 1]
        if kind == CLOSE:
            assert at + 2 + length == len(line.sent)
            return int.from_bytes(line.sent[at + 2 : at + 4], "big") if length else None
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
    assert ARRIVALS_PER_S - 2 <= line.read <= ARRIVALS_PER_S + 1


def test_all_sockets_of_a_device_count_together() -> None:
    arrivals = Arrivals(lambda: 0.0)
    sockets = [socket_of(*[frame(PING)] * 400, arrivals=arrivals)[0] for _ in range(3)]
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
    assert len(line.sent) <= 5 * 20  # the rest gets no answer


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
        (b"\x81\xff" + b"\xff" * 8, 1002),
        (b"\x81\xff" + b"\x7f" + b"\xff" * 2000, 1009),
        (frame(CLOSE), None),
        (frame(CLOSE, b"\x03"), 1002),
        (frame(CLOSE, b"\x0f\xa1"), 4001),  # it says itself what it is told
        (frame(CLOSE, b"\x03\xe8bye"), 1000),
    ],
)
def test_what_is_not_allowed_ends_the_socket_with_its_code(stream: bytes, code: int | None) -> None:
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
        close_code(line)


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


def test_what_comes_with_the_handshake_is_read_first() -> None:
    socket, _ = socket_of(
        frame(TEXT, b"one")[5:] + frame(TEXT, b"two"), early=frame(TEXT, b"one")[:5]
    )
    assert [socket.receive(1.0), socket.receive(1.0)] == ["one", "two"]


def test_what_was_said_before_a_fault_is_heard() -> None:
    socket, line = socket_of(frame(TEXT, b"stop") + b"\xff" * 50)
    assert socket.receive(1.0) == "stop"
    ends(socket, 1)
    assert close_code(line) == 1002


def test_nothing_is_heard_after_our_own_close() -> None:
    socket, _ = socket_of(frame(TEXT, b"one") + frame(TEXT, b"two"))
    assert socket.receive(1.0) == "one"
    socket.close(4001, "not paired any more")
    assert ends(socket, 1) == "not paired any more"


def test_a_long_reason_is_cut_to_what_a_frame_holds() -> None:
    socket, line = socket_of()
    socket.close(1013, "x" * 500)
    assert len(line.sent) == 2 + 125
    assert close_code(line) == 1013


def test_no_thread_is_begun_for_a_socket() -> None:
    before = threading.active_count()
    sockets = [socket_of(frame(TEXT, b"x"))[0] for _ in range(20)]
    assert [socket.receive(1.0) for socket in sockets] == ["x"] * 20
    assert threading.active_count() == before


def test_what_two_threads_send_stays_whole() -> None:
    socket, line = socket_of(*[frame(PING, b"p" * 100)] * 300)
    wire = line.sendall

    def slowly(data: bytes) -> None:
        for at in range(0, len(data), 16):  # others would get in between
            wire(bytes(data[at : at + 16]))
            time.sleep(0)

    line.sendall = slowly  # type: ignore[method-assign]
    threads = [
        threading.Thread(target=lambda: [socket.send("t" * 100) for _ in range(100)], daemon=True)
        for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    assert socket.receive(1.0) is None
    for thread in threads:
        thread.join(20.0)
    sent, texts = line.sent, 0
    while sent:
        kind, length = sent[0], sent[1]
        assert (kind, sent[2 : 2 + length]) in ((0x81, b"t" * 100), (0x8A, b"p" * 100))
        texts += kind == 0x81
        sent = sent[2 + length :]
    assert texts == 300


@pytest.mark.parametrize(
    "change",
    [
        {"REQUEST_METHOD": "POST"},
        {"SERVER_PROTOCOL": "HTTP/1.0"},
        {"HTTP_CONNECTION": "close"},
        {"HTTP_CONNECTION": "xupgrade"},  # a word, not a part of one
        {"HTTP_UPGRADE": "h2c"},
        {"HTTP_SEC_WEBSOCKET_VERSION": "8"},
        {"HTTP_SEC_WEBSOCKET_KEY": ""},
        {"HTTP_SEC_WEBSOCKET_KEY": "AAAA"},
        {"HTTP_SEC_WEBSOCKET_KEY": "\xff" * 24},
    ],
)
def test_a_bad_handshake_never_reaches_the_library(change: dict[str, str]) -> None:
    with pytest.raises(BadHandshake):
        handshake(REQUEST | change)


def test_the_library_sees_no_header_that_was_not_checked() -> None:
    sent = {"HTTP_COOKIE": "x=\x80", "HTTP_HOST": "xn--\xff@[::1]", "HTTP_ORIGIN": "y"}
    seen = handshake(REQUEST | sent | {"HTTP_SEC_WEBSOCKET_EXTENSIONS": "permessage-deflate"})
    assert {name for name in seen if name.startswith("HTTP_")} == {
        name for name in REQUEST if name.startswith("HTTP_")
    }
    assert seen["HTTP_HOST"] == "gazechair"
