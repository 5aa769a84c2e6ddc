"""The page's server over real loopback sockets, with a driver port that records."""

from __future__ import annotations

import contextlib
import json
import socket
import struct
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import simple_websocket

from gazechair.camera import Frame
from gazechair.config import Config, WebConfig
from gazechair.slots import Latest
from gazechair.web import WebError, WebServer, control, files

LONG_S = 20.0


class FakePort:
    """A driver port that notes what reaches it and refuses commands without a token."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.received: list[tuple[int, dict[str, Any]]] = []
        self.gone: list[int] = []
        self.version = 1
        self.level = "ok"
        self.clients = 0

    def connect(self, role: str) -> int:
        assert role == "driver"
        self.clients += 1
        return self.clients

    def disconnect(self, client: int) -> None:
        with self.changed:
            self.gone.append(client)
            self.changed.notify_all()

    def welcome(self, client: int) -> dict[str, Any]:
        return {"k": "welcome", "role": "driver", "client": client}

    def receive(self, client: int, message: dict[str, Any]) -> list[dict[str, Any]]:
        with self.changed:
            self.received.append((client, message))
            self.changed.notify_all()
        if message["k"] == "cmd" and "token" not in message:
            return [{"k": "refused", "what": "cmd", "reason": "stale_token", "detail": "no token"}]
        return []

    def snapshot(self, client: int) -> dict[str, Any]:
        return {"k": "state", "token": 7, "level": self.level}

    def wait_change(self, timeout_s: float, last_version: int) -> int:
        with self.changed:
            self.changed.wait_for(lambda: self.version != last_version, timeout_s)
            return self.version

    def health(self) -> dict[str, Any]:
        return {"board": {"state": "ok"}}

    def set_level(self, level: str) -> None:
        with self.changed:
            self.level = level
            self.version += 1
            self.changed.notify_all()

    def wait_for(self, condition: Callable[[], bool]) -> None:
        with self.changed:
            assert self.changed.wait_for(condition, LONG_S)

    def kinds(self) -> list[str]:
        return [message["k"] for _, message in self.received]


class Daemon(threading.Thread):
    """A client's receiving thread, which must not outlive the test run."""

    def __init__(self, target: Any) -> None:
        super().__init__(target=target, daemon=True)


class Page:
    """A WebSocket client."""

    def __init__(self, server: WebServer, path: str = "/ws/control", **headers: str) -> None:
        url = f"ws://127.0.0.1:{server.port}{path}"
        self.ws = simple_websocket.Client.connect(url, headers=headers, thread_class=Daemon)

    def send(self, message: object) -> None:
        self.ws.send(message if isinstance(message, str | bytes) else json.dumps(message))

    def next(self) -> Any:
        raw = self.ws.receive(LONG_S)
        assert raw is not None, "nothing came"
        return raw if isinstance(raw, bytes) else json.loads(raw)

    def next_of(self, kind: str) -> dict[str, Any]:
        while True:
            message: dict[str, Any] = self.next()
            if message["k"] == kind:
                return message

    def until_closed(self) -> tuple[int, str]:
        try:
            while self.ws.receive(LONG_S) is not None:
                pass
        except simple_websocket.ConnectionClosed as closed:
            return int(closed.reason), str(closed.message)
        raise AssertionError("still open")


@pytest.fixture
def port() -> FakePort:
    return FakePort()


@pytest.fixture
def video() -> Latest[Frame]:
    return Latest()


@pytest.fixture
def server(
    port: FakePort, video: Latest[Frame], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[WebServer]:
    (tmp_path / "strings").mkdir()
    (tmp_path / "index.html").write_text("<!doctype html><title>page</title>")
    (tmp_path / "driver.js").write_text("export {};")
    (tmp_path / "driver.css").write_text("body {}")
    (tmp_path / "__init__.py").write_text("secret = 1")
    (tmp_path / ".hidden.js").write_text("secret")
    (tmp_path / "strings" / "nl.json").write_text("{}")
    (tmp_path.parent / "outside.json").write_text("{}")
    monkeypatch.setattr(files, "web_folder", lambda: tmp_path)
    server = WebServer(Config(web=WebConfig(port=0)), port, video)
    server.start()
    yield server
    server.stop()


def get(server: WebServer, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
    request = urllib.request.Request(f"http://127.0.0.1:{server.port}{path}", headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=LONG_S) as response:
            return response.status, dict(response.headers), response.read()
    except urllib.error.HTTPError as error:
        return error.code, dict(error.headers), error.read()


# --- files -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "kind"),
    [
        ("/", "text/html; charset=utf-8"),
        ("/static/driver.js", "text/javascript; charset=utf-8"),
        ("/static/driver.css", "text/css; charset=utf-8"),
        ("/strings/nl.json", "application/json; charset=utf-8"),
        ("/health", "application/json"),
    ],
)
def test_files_come_with_their_type_and_strict_headers(
    server: WebServer, path: str, kind: str
) -> None:
    status, headers, _ = get(server, path)
    assert status == 200
    assert headers["Content-Type"] == kind
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert "unsafe" not in headers["Content-Security-Policy"]
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] in ("no-cache", "no-store")


def test_an_unchanged_file_is_not_sent_again(server: WebServer) -> None:
    _, headers, _ = get(server, "/static/driver.js")
    status, _, body = get(server, "/static/driver.js", **{"If-None-Match": headers["ETag"]})
    assert (status, body) == (304, b"")


@pytest.mark.parametrize(
    "path",
    [
        "/static/__init__.py",
        "/static/.hidden.js",
        "/static/../outside.json",
        "/static/%2e%2e/outside.json",
        "/static/..%2foutside.json",
        "/strings/../outside.json",
        "/strings/fr.json",
        "/static/",
        "/nothing",
    ],
)
def test_nothing_else_is_served(server: WebServer, path: str) -> None:
    assert get(server, path)[0] == 404


def test_a_foreign_host_name_is_refused(server: WebServer) -> None:
    status, _, body = get(server, "/", Host="evil.example")
    assert status == 403
    assert b"is not this machine" in body


def test_the_health_of_all_parts_is_shown(server: WebServer) -> None:
    assert json.loads(get(server, "/health")[2]) == {"board": {"state": "ok"}}


def test_a_taken_port_is_one_plain_line(server: WebServer, port: FakePort) -> None:
    second = WebServer(Config(web=WebConfig(port=server.port)), port, None)
    with pytest.raises(WebError, match=r"can't serve the page at .*choose another web\.port"):
        second.start()
    second.stop()


# --- control ---------------------------------------------------------------------------------


def test_a_page_is_welcomed_and_then_hears_states(server: WebServer) -> None:
    page = Page(server)
    assert page.next()["k"] == "welcome"
    assert page.next() == {"k": "state", "token": 7, "level": "ok"}
    assert page.next()["k"] == "state"


def test_a_change_is_told(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    page.next_of("state")
    port.set_level("error")
    while page.next_of("state")["level"] != "error":
        pass


def test_messages_reach_the_driver_port_with_their_client(
    server: WebServer, port: FakePort
) -> None:
    first, second = Page(server), Page(server)
    first.next_of("welcome")
    client = second.next_of("welcome")["client"]
    second.send({"k": "stop"})
    port.wait_for(lambda: (client, {"k": "stop"}) in port.received)


def test_a_refusal_goes_back_to_its_page(server: WebServer) -> None:
    page = Page(server)
    page.send({"k": "cmd", "verb": "forward"})
    assert page.next_of("refused")["reason"] == "stale_token"


@pytest.mark.parametrize(
    "bad",
    [
        b"\x00\x01",
        "",
        "forward",
        "{",
        "[]",
        "5",
        "null",
        '{"k":5}',
        "{}",
        '{"k":"cmd","token":NaN}',
        '{"k":"cmd","token":Infinity}',
        "[" * 200,
        '{"k":"' + "x" * 300 + '"}',
        '{"k":"\u20ac' + "\u20ac" * 90 + '"}',
    ],
)
def test_a_malformed_message_is_refused_and_the_socket_lives(
    server: WebServer, port: FakePort, bad: str | bytes
) -> None:
    page = Page(server)
    page.send(bad)
    answer = page.next_of("refused")
    assert (answer["what"], answer["reason"]) == ("message", "bad_message")
    assert "\n" not in answer["detail"]
    page.send({"k": "hb", "token": 1})
    port.wait_for(lambda: port.kinds() == ["hb"])


def test_an_oversized_message_closes_the_socket(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    page.send("x" * 1_100)
    code, _ = page.until_closed()
    assert code == 1009
    port.wait_for(lambda: port.gone == [1])
    assert port.received == []


def test_what_comes_too_fast_is_refused_but_never_a_stop(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    for _ in range(180):
        page.send({"k": "hb", "token": 1})
    for _ in range(20):
        page.send({"k": "stop"})
    assert page.next_of("refused")["reason"] == "too_fast"
    port.wait_for(lambda: port.kinds().count("stop") == 20)


def test_a_flood_ends_the_connection(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    with contextlib.suppress(OSError, simple_websocket.ConnectionClosed):
        for _ in range(100_000):
            page.send({"k": "hb", "token": 1})
    port.wait_for(lambda: port.gone == [1])


def test_a_closed_socket_disconnects_its_client(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    page.next()
    page.ws.close()
    port.wait_for(lambda: port.gone == [1])


def test_a_cut_connection_disconnects_its_client(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    page.next()
    page.ws.sock.shutdown(socket.SHUT_RDWR)
    port.wait_for(lambda: port.gone == [1])


def test_at_most_eight_pages(server: WebServer, port: FakePort) -> None:
    pages = [Page(server) for _ in range(control.MAX_CLIENTS)]
    for page in pages:
        page.next_of("state")
    assert Page(server).until_closed()[0] == 1013
    pages[0].ws.close()
    port.wait_for(lambda: len(port.gone) == 1)
    deadline_s = time.monotonic() + LONG_S
    while time.monotonic() < deadline_s:
        late = Page(server)
        if late.next()["k"] == "welcome":
            return
    pytest.fail("the freed place was not given again")


@pytest.mark.parametrize("path", ["/ws/control", "/ws/video"])
@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:1"])
def test_a_foreign_origin_is_refused(
    server: WebServer, port: FakePort, path: str, origin: str
) -> None:
    with pytest.raises(simple_websocket.ConnectionError):
        Page(server, path, Origin=origin)
    assert port.clients == 0


def test_the_page_s_own_origin_is_let_in(server: WebServer) -> None:
    # This client's Host has no port, a browser's has; both must be equal to their Origin's.
    page = Page(server, Origin="http://127.0.0.1")
    assert page.next()["k"] == "welcome"


def test_a_slow_reader_delays_nobody_else(server: WebServer, port: FakePort) -> None:
    slow = Page(server, "/ws/control")
    slow.next()
    # It reads no more, and its backlog of states is kept growing by changes.
    slow.ws.input_buffer = _Blocking()
    quick = Page(server)
    quick.next_of("state")
    for number in range(30):
        quick.send({"k": "hb", "token": number})
        port.set_level(f"level {number}")
        while quick.next_of("state")["level"] != f"level {number}":
            pass
    port.wait_for(lambda: port.kinds().count("hb") == 30)


class _Blocking(list[Any]):
    def append(self, item: Any) -> None:
        threading.Event().wait(60.0)


def test_stopping_the_server_disconnects_everyone(server: WebServer, port: FakePort) -> None:
    page = Page(server)
    page.next()
    server.stop()
    assert port.gone == [1]
    page.until_closed()


@pytest.mark.parametrize(
    "headers",
    [
        {"Upgrade": "websocket", "Connection": "Upgrade"},
        {"Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "1"},
        {},
    ],
)
def test_a_broken_handshake_is_answered_in_one_line(
    server: WebServer, port: FakePort, headers: dict[str, str]
) -> None:
    assert get(server, "/ws/control", **headers)[0] == 400
    assert port.clients == 0


# --- picture ---------------------------------------------------------------------------------


def frame(tag: bytes, age_s: float = 0.0) -> Frame:
    return Frame(b"\xff\xd8" + tag + b"\xff\xd9", time.monotonic() - age_s)


def shown(raw: bytes) -> tuple[int, int, bytes]:
    sequence, age_ms = struct.unpack_from("<II", raw)
    return sequence, age_ms, raw[8:]


def test_the_next_picture_waits_for_the_acknowledgement_and_is_the_newest(
    server: WebServer, video: Latest[Frame]
) -> None:
    page = Page(server, "/ws/video")
    video.put(frame(b"one"))
    sequence, age_ms, jpeg = shown(page.next())
    assert (sequence, jpeg) == (1, b"\xff\xd8one\xff\xd9")
    assert age_ms < 1000
    video.put(frame(b"two"))
    video.put(frame(b"three"))
    assert page.ws.receive(0.3) is None
    page.send("1")
    assert shown(page.next())[::2] == (2, b"\xff\xd8three\xff\xd9")


def test_the_age_counts_from_acquisition(server: WebServer, video: Latest[Frame]) -> None:
    page = Page(server, "/ws/video")
    video.put(frame(b"old", age_s=0.4))
    assert shown(page.next())[1] >= 400


def test_a_picture_too_old_to_help_is_not_sent(server: WebServer, video: Latest[Frame]) -> None:
    page = Page(server, "/ws/video")
    video.put(frame(b"ancient", age_s=5.0))
    assert page.ws.receive(0.3) is None


def test_a_wrong_acknowledgement_closes_the_socket(server: WebServer, video: Latest[Frame]) -> None:
    page = Page(server, "/ws/video")
    page.send("99")
    assert page.until_closed()[0] == 1003
