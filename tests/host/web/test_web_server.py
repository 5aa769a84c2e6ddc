"""Files, headers and access rules of the pages' server; how many connections it bears."""

from __future__ import annotations

import errno
import gzip
import json
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import simple_websocket

from gazechair.board.caretaker_settings import CaretakerSettings
from gazechair.config.settings import Config, WebConfig
from gazechair.web import PageParts, WebError, WebServer
from gazemeasure.page.raw_page import upgrade


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
def test_files_come_with_their_type_and_strict_headers(path: str, kind: str, get: Any) -> None:
    status, headers, _ = get(path)
    assert status == 200
    assert headers["Content-Type"] == kind
    assert "default-src 'none'" in headers["Content-Security-Policy"]
    assert "unsafe" not in headers["Content-Security-Policy"]
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] in ("no-cache", "no-store")


@pytest.mark.parametrize("accepted", ["identity", "gzip, deflate"])
def test_an_unchanged_file_is_not_sent_again(accepted: str, get: Any) -> None:
    accept = {"Accept-Encoding": accepted}
    _, headers, _ = get("/static/driver.js", **accept)
    status, _, body = get("/static/driver.js", **accept, **{"If-None-Match": headers["ETag"]})
    assert (status, body) == (304, b"")


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("/", "index.html"),
        ("/static/driver.js", "driver.js"),
        ("/strings/nl.json", "strings/nl.json"),
    ],
)
def test_a_browser_that_unpacks_gzip_gets_a_text_in_half_the_bytes(
    path: str, name: str, get: Any, pages: Path
) -> None:
    (pages / name).write_text(json.dumps({f"word {k}": "as long as in a page" for k in range(99)}))
    _, plain, whole = get(path)
    _, packed, small = get(path, **{"Accept-Encoding": "gzip, deflate, br"})
    assert packed["Content-Encoding"] == "gzip"
    assert gzip.decompress(small) == whole
    assert len(small) < len(whole) / 2
    assert packed["ETag"] != plain["ETag"]
    assert packed["Vary"] == plain["Vary"] == "Accept-Encoding"


@pytest.mark.parametrize("accepted", ["", "identity", "gzip;q=0", "xgzip", "gzip," * 100])
def test_whoever_does_not_ask_for_gzip_as_browsers_do_gets_the_plain_text(
    accepted: str, get: Any
) -> None:
    _, headers, body = get("/static/driver.js", **{"Accept-Encoding": accepted})
    assert headers.get("Content-Encoding") is None
    assert body == get("/static/driver.js")[2]


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
        f"/strings/{300 * 'a'}.json",
        f"/static/{300 * 'a'}.js",
        "/static/",
        "/nothing",
    ],
)
def test_nothing_else_is_served(path: str, get: Any) -> None:
    assert get(path)[0] == 404


def test_a_foreign_host_name_is_refused(get: Any) -> None:
    status, _, body = get("/", Host="evil.example")
    assert status == 403
    assert b"is not this machine" in body


def test_the_health_of_all_parts_is_shown(get: Any) -> None:
    assert json.loads(get("/health")[2]) == {"board": {"state": "ok"}}


@pytest.fixture
def other(
    port: Any, desk: Any, board: Any, alerts: Any, steps: Any, maps: Any, tmp_path: Path
) -> Callable[[WebConfig], WebServer]:
    """Makes another server, with `tmp_path` as its state folder."""

    def make(web: WebConfig) -> WebServer:
        parts = PageParts(port, None, CaretakerSettings(board), alerts, steps, maps)
        return WebServer(Config(web=web), parts, desk, tmp_path)

    return make


def test_a_taken_port_is_one_plain_line(
    server: WebServer, other: Callable[[WebConfig], WebServer]
) -> None:
    second = other(WebConfig(port=server.port))
    with pytest.raises(WebError, match=r"can't serve the page at .*choose another web\.port"):
        second.start()
    second.stop()


@pytest.mark.parametrize("host", ["192.0.2.77", "none.invalid", "192.168..5"])
def test_an_address_of_another_machine_is_said_to_be_one_and_named_by_no_certificate(
    other: Callable[[WebConfig], WebServer], host: str, tmp_path: Path
) -> None:
    server = other(WebConfig(host=host, port=0))
    with pytest.raises(WebError, match=r"must be an address of this machine \(127\.0\.0\.1"):
        server.start()
    server.stop()
    assert not (tmp_path / "tls").exists()


def test_a_port_that_only_root_may_use_says_so(
    other: Callable[[WebConfig], WebServer], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(socket.socket, "bind", refuse)
    with pytest.raises(
        WebError, match=r"\(Permission denied\); choose a web\.port of 1024 or more"
    ):
        other(WebConfig(port=80)).start()


@pytest.mark.parametrize("path", ["/ws/control", "/ws/video"])
@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1:1"])
def test_a_foreign_origin_is_refused(port: Any, path: str, origin: str, open_page: Any) -> None:
    with pytest.raises(simple_websocket.ConnectionError):
        open_page(path, Origin=origin)
    assert port.clients == 0


def test_the_page_s_own_origin_is_let_in(open_page: Any) -> None:
    # This client's Host has no port, a browser's has; both must be equal to their Origin's.
    page = open_page(Origin="http://127.0.0.1")
    assert page.next()["k"] == "welcome"


def test_stopping_the_server_disconnects_everyone(
    server: WebServer, port: Any, open_page: Any
) -> None:
    page = open_page()
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
    port: Any, headers: dict[str, str], get: Any
) -> None:
    assert get("/ws/control", **headers)[0] == 400
    assert port.clients == 0


@pytest.mark.parametrize("path", ["/", "/health", "/ws//control", "/ws/control/", "//ws/control"])
def test_other_addresses_become_no_socket(
    server: WebServer, port: Any, driver: Any, path: str
) -> None:
    with pytest.raises(ConnectionError, match=r"'HTTP/1.1 [34]"):
        upgrade(server.port, path, driver.headers["Cookie"])
    assert port.clients == 0
