"""The slow network: its rate, its delay, its bounded buffer, and a drop that keeps what waits."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator

import pytest

from gazemeasure.page.shaper import Shaper

PATIENCE_S = 30


@pytest.fixture
def echo() -> Iterator[int]:
    """Port of a server that sends everything back."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        while True:
            try:
                connection, _ = server.accept()
            except OSError:
                return
            threading.Thread(target=answer, args=(connection,), daemon=True).start()

    def answer(connection: socket.socket) -> None:
        with connection:
            while data := connection.recv(65536):
                connection.sendall(data)

    threading.Thread(target=serve, daemon=True).start()
    yield server.getsockname()[1]
    server.shutdown(socket.SHUT_RDWR)
    server.close()


def connect(shaper: Shaper) -> socket.socket:
    return socket.create_connection(("127.0.0.1", shaper.port), timeout=PATIENCE_S)


def receive(connection: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        data += connection.recv(65536)
    return data


def test_everything_arrives_in_order_and_no_sooner_than_rate_and_delay_allow(echo: int) -> None:
    sent = bytes(range(256)) * 80  # 20 kB
    with Shaper(echo, mbit_s=0.8, delay_ms=50) as shaper, connect(shaper) as connection:
        start_s = time.monotonic()
        connection.sendall(sent)
        assert receive(connection, len(sent)) == sent
        # 0.2 s up, the last packet's own time down, 50 ms each way
        assert time.monotonic() - start_s >= 0.2 + 0.1
        assert shaper.up.carried == shaper.down.carried == len(sent)


def test_the_buffer_is_bounded(echo: int) -> None:
    with Shaper(echo, mbit_s=0.05) as shaper, connect(shaper) as connection:
        connection.settimeout(0.5)
        with pytest.raises(TimeoutError):
            connection.sendall(bytes(8_000_000))
        assert shaper.up.most_waiting <= 64 * 1024


def test_one_connection_waits_for_the_other(echo: int) -> None:
    with Shaper(echo, mbit_s=0.4) as shaper, connect(shaper) as big, connect(shaper) as small:
        big.sendall(bytes(20_000))  # 0.4 s
        deadline_s = time.monotonic() + PATIENCE_S
        while shaper.up.carried < 20_000 and time.monotonic() < deadline_s:
            time.sleep(0.001)
        start_s = time.monotonic()
        small.sendall(b"x")
        assert receive(small, 1) == b"x"
        assert time.monotonic() - start_s >= 0.2
        receive(big, 20_000)


def test_what_waits_through_a_drop_arrives_after_it(echo: int) -> None:
    with Shaper(echo) as shaper, connect(shaper) as connection:
        connection.sendall(b"a")
        assert receive(connection, 1) == b"a"
        shaper.drop(True)
        connection.sendall(b"b")
        connection.settimeout(0.3)
        with pytest.raises(TimeoutError):
            connection.recv(1)
        connection.settimeout(PATIENCE_S)
        shaper.drop(False)
        assert receive(connection, 1) == b"b"


def test_a_closed_connection_is_closed_at_the_other_end(echo: int) -> None:
    with Shaper(echo) as shaper, connect(shaper) as connection:
        connection.sendall(b"last")
        connection.shutdown(socket.SHUT_WR)
        assert receive(connection, 4) == b"last"
        assert connection.recv(1) == b""
