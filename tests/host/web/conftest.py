"""The page's server on loopback with a driver port that records, and clients to talk to it."""

from __future__ import annotations

import json
import threading
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
from gazechair.web import WebServer, files

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

    def token(self) -> int:
        return 7

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


@pytest.fixture
def open_page(server: WebServer) -> Callable[..., Page]:
    """Opens a WebSocket to the server: open_page(path="/ws/control", **headers)."""

    def opener(path: str = "/ws/control", **headers: str) -> Page:
        return Page(server, path, **headers)

    return opener


@pytest.fixture
def get(server: WebServer) -> Callable[..., tuple[int, dict[str, str], bytes]]:
    """Fetches a path by HTTP: (status, headers, body)."""

    def getter(path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
        request = urllib.request.Request(f"http://127.0.0.1:{server.port}{path}", headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=LONG_S) as response:
                return response.status, dict(response.headers), response.read()
        except urllib.error.HTTPError as error:
            return error.code, dict(error.headers), error.read()

    return getter
