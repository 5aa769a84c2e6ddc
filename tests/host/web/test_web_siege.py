"""A hostile network, by raw sockets: refused with a reason, and the driver unaffected."""

from __future__ import annotations

import contextlib
import io
import os
import socket
import ssl
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import simple_websocket

from gazechair.board.caretaker_settings import CaretakerSettings
from gazechair.config.settings import Config, WebConfig
from gazechair.people.pairing import Paired
from gazechair.web import PageParts, WebServer, connection_limits, handler
from gazemeasure.page.raw_page import frame, upgrade

LONG_S = 20.0
HELLO = (
    "GET /ws/control HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
    "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n{cookie}\r\n"
)


class Siege:
    """Raw connections to the server, and the driver's page, which must not notice."""

    def __init__(self, server: Any, driver: Any, port: Any) -> None:
        self._server = server
        self._driver = driver
        self._port = port
        self._lines: list[socket.socket] = []
        self.page = driver.open()
        self.page.next_of("state")

    def line(self, data: bytes = b"") -> socket.socket:
        """A connection that has sent this."""
        line = socket.create_connection(("127.0.0.1", self._server.port), LONG_S)
        self._lines.append(line)
        with contextlib.suppress(OSError):
            line.sendall(data)
        return line

    def answer(self, data: bytes) -> bytes:
        """Everything that comes back for this."""
        line, answer = self.line(data), b""
        with contextlib.suppress(ConnectionResetError):
            while part := line.recv(4096):
                answer += part
        return answer

    def driver_unaffected(self) -> None:
        """Assert that the driver's page continues, and a new one is admitted."""
        self._port.set_level(f"level {self._port.version}")
        level = self._port.level
        while self.page.next_of("state")["level"] != level:
            pass
        stops = self._port.kinds().count("stop")
        self.page.send({"k": "stop"})
        self._port.wait_for(lambda: self._port.kinds().count("stop") > stops)
        assert self._driver.open().next()["k"] == "welcome"
        assert self._driver.get("/")[0] == 200

    def close(self) -> None:
        for line in self._lines:
            line.close()


@pytest.fixture
def siege(server: Any, driver: Any, port: Any) -> Iterator[Siege]:
    siege = Siege(server, driver, port)
    yield siege
    siege.close()


def test_200_idle_connections_delay_nobody(siege: Siege) -> None:
    for _ in range(200):
        siege.line()
    siege.driver_unaffected()


def test_200_half_requests_delay_nobody(siege: Siege) -> None:
    for _ in range(200):
        siege.line(b"GET / HTTP/1.1\r\nHost: ")
    siege.driver_unaffected()


def test_an_idle_connection_is_cut(siege: Siege, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(connection_limits, "LONGEST_NEW_S", 0.2)
    assert siege.answer(b"") == b""
    assert siege.answer(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ") == b""
    siege.page.next_of("state")  # it has been here for longer than that, and stays


@pytest.mark.parametrize(
    "data",
    [
        b"GET /" + b"x" * 20_000 + b" HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"X: " + b"y" * 20_000 + b"\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 4000 + b"\r\n",
    ],
)
def test_endless_headers_are_refused_in_one_line(siege: Siege, data: bytes) -> None:
    answer = siege.answer(data)
    # The reason, unless the reset of a connection that goes on talking overtakes it.
    assert answer == b"" or b" 431 " in answer.splitlines()[0]
    siege.driver_unaffected()


@pytest.mark.parametrize("size", [1, 100, 10_000])
def test_binary_garbage_is_no_request(siege: Siege, size: int) -> None:
    for _ in range(10):
        siege.line(os.urandom(size) + b"\r\n\r\n")
    answer = siege.answer(b"\x16\x03\x01\x02\x00\x01\r\n\r\n")
    assert answer == b"" or b"400" in answer
    siege.driver_unaffected()


@pytest.mark.parametrize(
    ("cookie", "status"),
    [("", b"401"), ("Cookie: {name}=" + "B" * 43 + "\r\n", b"401"), ("Origin: x\r\n", b"403")],
)
def test_a_socket_without_a_pairing_is_told_why(
    siege: Siege, server: Any, cookie: str, status: bytes
) -> None:
    cookie = cookie.format(name=f"gazechair-{server.port}")
    answer = siege.answer(HELLO.format(port=server.port, cookie=cookie).encode())
    assert answer.split(b" ")[1] == status
    assert b'"reason": "not_' in answer
    siege.driver_unaffected()


@pytest.mark.parametrize("size", [2, 130, 70_000])
def test_binary_garbage_on_a_paired_socket_ends_that_socket_only(
    siege: Siege, server: Any, driver: Any, size: int
) -> None:
    cookie = f"Cookie: {driver.headers['Cookie']}\r\n"
    line = siege.line(HELLO.format(port=server.port, cookie=cookie).encode())
    assert line.recv(1000).startswith(b"HTTP/1.1 101")
    with contextlib.suppress(OSError):
        line.sendall(b"\xff" * size)
        while line.recv(4096):
            pass
    siege.driver_unaffected()


def test_a_flood_of_connections_leaves_the_driver_his_place(siege: Siege) -> None:
    for _ in range(400):
        siege.line(b"GET /pair HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").close()
    siege.driver_unaffected()


@pytest.mark.parametrize("path", ["/ws/control", "/ws/video"])
@pytest.mark.parametrize(
    "data",
    [frame(9), frame(10, b"x" * 125), frame(1, last=False) + frame(0, last=False) * 9],
    ids=["pings", "pongs", "empty fragments"],
)
def test_a_flood_of_pings_ends_its_socket_and_the_driver_goes_on(
    siege: Siege, server: Any, visitor: Any, path: str, data: bytes
) -> None:
    cookie = visitor("viewer").headers["Cookie"]
    for _ in range(5):  # opened again whenever it is cut
        with contextlib.suppress(ConnectionError), upgrade(server.port, path, cookie) as line:
            for _ in range(10_000):
                line.sendall(data * 100)
            pytest.fail("it was never cut")
    siege.driver_unaffected()


def test_four_tabs_never_lock_the_tablet_out(visitor: Any, port: Any) -> None:
    phone, tablet = visitor("driver"), visitor("driver")
    tabs = [phone.open() for _ in range(6)]
    page = tablet.open()
    assert page.next()["k"] == "welcome"
    page.next_of("state")
    page.send({"k": "stop"})
    port.wait_for(lambda: "stop" in port.kinds())
    assert sum(tab is not None for tab in tabs) == 6


# Encrypted


class Encrypted:
    def __init__(self, server: WebServer, folder: Path, cookie: str) -> None:
        self.server = server
        self.cookie = cookie
        self.context = ssl.create_default_context(cafile=folder / "tls" / "authority.crt")

    def line(self, data: bytes = b"") -> socket.socket:
        line = socket.create_connection(("127.0.0.1", self.server.port), LONG_S)
        line.sendall(data)
        return line

    def shake_hands(self, name: str = "127.0.0.1") -> ssl.SSLSocket:
        return self.context.wrap_socket(self.line(), server_hostname=name)

    def open(self) -> Any:
        url = f"wss://127.0.0.1:{self.server.port}/ws/control"
        headers = {"Cookie": self.cookie, "Origin": "https://127.0.0.1"}
        return simple_websocket.Client(url, headers=headers, ssl_context=self.context)


@pytest.fixture(scope="module")
def certificate_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One certificate for all: making it takes a moment."""
    return tmp_path_factory.mktemp("state")


@pytest.fixture
def encrypted(
    port: Any,
    pages: Path,
    desk: Any,
    board: Any,
    alerts: Any,
    steps: Any,
    maps: Any,
    certificate_folder: Path,
) -> Iterator[Encrypted]:
    config = Config(web=WebConfig(port=0, tls=True))
    parts = PageParts(port, None, CaretakerSettings(board), alerts, steps, maps)
    server = WebServer(config, parts, desk, certificate_folder)
    server.start()
    paired = desk.pair(desk.new_code("driver").text, "tablet", "192.0.2.1")
    assert isinstance(paired, Paired)
    cookie = f"__Host-gazechair-{server.port}={paired.token}"
    yield Encrypted(server, certificate_folder, cookie)
    server.stop()


def test_200_half_open_handshakes_delay_nobody(encrypted: Encrypted, port: Any) -> None:
    lines = [encrypted.line(b"\x16\x03\x01" if k % 2 else b"") for k in range(200)]
    socket_of_driver = encrypted.open()
    assert '"welcome"' in socket_of_driver.receive(LONG_S)
    socket_of_driver.send('{"k":"stop"}')
    port.wait_for(lambda: "stop" in port.kinds())
    for line in lines:
        line.close()


def test_a_handshake_has_a_deadline(encrypted: Encrypted, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(handler, "_HANDSHAKE_S", 0.2)
    line = encrypted.line(b"\x16\x03\x01\x02\x00\x01")
    assert line.recv(100) == b""


def test_plain_http_is_told_to_come_encrypted(encrypted: Encrypted) -> None:
    answer = encrypted.line(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n").recv(4096)
    assert answer.startswith(b"HTTP/1.1 400")
    assert b"open it with https://" in answer


@pytest.mark.parametrize("data", [b"\x16" + b"\x00" * 50, b"\x16\x03\x01\x00\x05hello"])
def test_a_broken_handshake_is_ended(encrypted: Encrypted, data: bytes) -> None:
    line = encrypted.line(data)
    line.shutdown(socket.SHUT_WR)
    with contextlib.suppress(ConnectionResetError):
        while line.recv(4096):
            pass
    assert encrypted.shake_hands().version() in ("TLSv1.2", "TLSv1.3")


def test_both_directions_at_once_stay_whole(encrypted: Encrypted, port: Any) -> None:
    page = encrypted.open()
    for number in range(90):
        page.send(f'{{"k":"hb","token":{number}}}')
        port.set_level(f"level {number}")
    port.wait_for(lambda: port.kinds().count("hb") == 90)
    while '"level 89"' not in page.receive(LONG_S):
        pass


def test_the_cookie_is_bound_to_encryption(encrypted: Encrypted, desk: Any) -> None:
    code = desk.new_code("viewer").text
    body = f'{{"code": "{code}"}}'.encode()
    line = encrypted.shake_hands()
    line.sendall(
        b"POST /pair HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
        + f"Content-Length: {len(body)}\r\n\r\n".encode()
        + body
    )
    answer = b""
    while part := line.recv(4096):
        answer += part
    assert b"Set-Cookie: __Host-gazechair-" in answer
    assert b"; Secure; HttpOnly; Path=/; SameSite=Strict" in answer


def test_a_caretakers_file_comes_through_the_encryption(
    encrypted: Encrypted, desk: Any, maps: Any
) -> None:
    paired = desk.pair(desk.new_code("caretaker").text, "phone", "192.0.2.1")
    assert isinstance(paired, Paired)
    packed = io.BytesIO(maps.files("a"))
    maps.change({"map": "a", "delete": True})
    with zipfile.ZipFile(packed, "a") as pack:
        pack.writestr("notes.txt", os.urandom(2_000_000))  # bytes that no packing makes fewer
    body = packed.getvalue()
    port = encrypted.server.port
    head = (
        f"POST /maps/import HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n"
        f"Origin: https://127.0.0.1:{port}\r\nCookie: __Host-gazechair-{port}={paired.token}\r\n"
        f"Content-Type: application/zip\r\nContent-Length: {len(body)}\r\n\r\n"
    )
    with encrypted.shake_hands() as line:
        line.sendall(head.encode() + body)
        assert line.recv(65_536).startswith(b"HTTP/1.1 200 ")
    assert len(maps.as_json()["maps"]) == 1


def test_the_certificate_names_this_machine(encrypted: Encrypted, certificate_folder: Path) -> None:
    for name in ("127.0.0.1", "localhost", socket.gethostname().lower() + ".local"):
        encrypted.shake_hands(name).close()
    with pytest.raises(ssl.SSLCertVerificationError):
        encrypted.shake_hands("evil.example")
    made = {
        path.name: path.stat().st_mode & 0o777 for path in (certificate_folder / "tls").iterdir()
    }
    assert made["host.key"] == 0o600
    assert "authority.key" not in made  # no other certificate can ever be made
