"""The page's server on loopback with a driver port that records, and clients to talk to it."""

from __future__ import annotations

import contextlib
import json
import socket
import threading
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import simple_websocket
from wsproto.utilities import LocalProtocolError

from fakeboard import FakeBoard
from gazechair.base.latest_value import Latest
from gazechair.board.caretaker_settings import CaretakerSettings
from gazechair.config.settings import Config, WebConfig
from gazechair.people.pairing import Paired, PairingDesk
from gazechair.picture.camera import Frame
from gazechair.sensing.mapping.building.occupancy_grid import OccupancyGrid
from gazechair.sensing.mapping.desk import MapDesk
from gazechair.sensing.mapping.stored.home_map import HomeMap
from gazechair.sensing.mapping.stored.store import MapStore
from gazechair.web import PageParts, WebServer, control_sockets, files, page_client

LONG_S = 20.0


class FakePort:
    """A driver port that records its messages and refuses commands without a token."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self.received: list[tuple[int, dict[str, Any]]] = []
        self.gone: list[int] = []
        self.version, self.level = 1, "ok"
        self.ttl_ms: int | None = None
        self.clients = 0
        self.roles: list[str] = []

    def connect(self, role: str) -> int:
        self.roles.append(role)
        self.clients += 1
        return self.clients

    def disconnect(self, client: int) -> None:
        with self.changed:
            if client not in self.gone:
                self.gone.append(client)
            self.changed.notify_all()

    def welcome(self, client: int) -> dict[str, Any]:
        role = {"k": "welcome", "role": "driver", "client": client}
        return {**role, "command_ttl_ms": self.ttl_ms}

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


class FakeAlerts:
    """A book that records who did what."""

    def __init__(self) -> None:
        self.received: list[tuple[int | str, str]] = []

    def as_json(self) -> dict[str, Any]:
        return {"revision": 1, "routes": ["zus"], "alerts": []}

    def acknowledge(self, number: int, by: str) -> bool:
        self.received.append((number, by))
        return True

    def test(self, by: str) -> None:
        self.received.append(("test", by))


class Daemon(threading.Thread):
    """A client's receiving thread, which must not outlive the test run."""

    def __init__(self, target: Any) -> None:
        super().__init__(target=target, daemon=True)
        self._client = target.__self__

    def run(self) -> None:
        # What came together with the handshake's answer; the library would not look at it.
        self._client.connected = self._client._handle_events()
        super().run()


class Page:
    """A WebSocket client."""

    def __init__(self, server: WebServer, path: str = "/ws/control", **headers: str) -> None:
        url = f"ws://127.0.0.1:{server.port}{path}"
        self.ws = simple_websocket.Client.connect(url, headers=headers, thread_class=Daemon)

    def send(self, message: object) -> None:
        try:
            self.ws.send(message if isinstance(message, str | bytes) else json.dumps(message))
        except LocalProtocolError:  # the server's end was heard a moment before the library said so
            raise simple_websocket.ConnectionClosed from None

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
def desk(tmp_path: Path) -> PairingDesk:
    return PairingDesk(tmp_path / "state")


@pytest.fixture
def pages(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of pages, and around it what must not be served."""
    folder = tmp_path / "pages"
    (folder / "strings").mkdir(parents=True)
    for name in ("index", "caretaker", "pair"):
        (folder / f"{name}.html").write_text(f"<!doctype html><title>{name}</title>")
    for name in ("driver.js", "pair.js", "strings.js"):
        (folder / name).write_text("export {};")
    for name in ("driver.css", "pair.css"):
        (folder / name).write_text("body {}")
    (folder / "icon.svg").write_text("<svg/>")
    (folder / "__init__.py").write_text("secret = 1")
    (folder / ".hidden.js").write_text("secret")
    (folder / "strings" / "nl.json").write_text("{}")
    (tmp_path / "outside.json").write_text("{}")
    monkeypatch.setattr(files, "web_folder", lambda: folder)
    monkeypatch.setattr(control_sockets, "_LOOK_S", 0.02)  # ends sooner
    monkeypatch.setattr(page_client, "_SILENT_S", 600.0)  # visitors send no heartbeats
    monkeypatch.setattr(page_client, "_LOOK_S", 0.02)
    return folder


@pytest.fixture
def board() -> FakeBoard:
    return FakeBoard()


@pytest.fixture
def alerts() -> FakeAlerts:
    return FakeAlerts()


class FakeSteps:
    """A first drive that records its requests; `refusal` is its next answer."""

    def __init__(self) -> None:
        self.received: list[dict[str, Any]] = []
        self.holds_settings = False
        self.refusal: tuple[str, str] | None = None

    def status(self) -> dict[str, Any]:
        return {"steps": [{"step": "versions", "done": True}], "run": {"step": ""}}

    def ask(self, request: dict[str, Any]) -> tuple[str, str] | None:
        self.received.append(request)
        return self.refusal


@pytest.fixture
def steps() -> FakeSteps:
    return FakeSteps()


@pytest.fixture
def maps(tmp_path: Path) -> MapDesk:
    """One map, "a", of a floor of 2 m by 2 m; no lidar."""
    cells = np.full((40, 40), 5, dtype=np.uint16)
    cells[0] = 0
    grid = OccupancyGrid(0.05, np.zeros(2), 5 - cells, cells)
    HomeMap("home", grid).save(tmp_path / "maps" / "a.map")
    return MapDesk(MapStore(tmp_path / "maps"), None)


@pytest.fixture
def server(
    port: FakePort,
    video: Latest[Frame],
    desk: PairingDesk,
    pages: Path,
    board: FakeBoard,
    alerts: FakeAlerts,
    steps: FakeSteps,
    maps: MapDesk,
    tmp_path: Path,
) -> Iterator[WebServer]:
    parts = PageParts(port, video, CaretakerSettings(board), alerts, steps, maps)
    server = WebServer(Config(web=WebConfig(port=0)), parts, desk, tmp_path / "state")
    server.start()
    yield server
    server.stop()


class Visitor:
    """A device that visits the server, paired with a role, or without one: not paired."""

    def __init__(self, server: WebServer, desk: PairingDesk, role: str | None = "driver") -> None:
        self._server = server
        self.id = ""
        self.headers: dict[str, str] = {}
        if role is not None:
            paired = desk.pair(desk.new_code(role).text, f"a {role}", "192.0.2.1")
            assert isinstance(paired, Paired)
            self.id = paired.device.id
            self.headers = {"Cookie": f"gazechair-{server.port}={paired.token}"}

    def open(self, path: str = "/ws/control", **headers: str) -> Page:
        """Open a WebSocket."""
        return Page(self._server, path, **{**self.headers, **headers})

    def get(self, path: str, **headers: str) -> tuple[int, dict[str, str], bytes]:
        """Fetch a path; redirections are not followed."""
        return self._ask(path, None, headers)

    def post(self, path: str, content: object, **headers: str) -> tuple[int, dict[str, str], Any]:
        """Post JSON: (status, headers, answer)."""
        headers = {"Content-Type": "application/json", **headers}
        status, reported, raw = self._ask(path, json.dumps(content).encode(), headers)
        return status, reported, json.loads(raw)

    def line(
        self, path: str, content: bytes, length: int | None = None, **headers: str
    ) -> socket.socket:
        """A raw connection on which this was sent, as the beginning of `length` bytes."""
        sent = {"Host": f"127.0.0.1:{self._server.port}", "Content-Type": "application/zip"}
        sent |= {"Content-Length": str(len(content) if length is None else length)}
        lines = [f"{name}: {value}" for name, value in {**sent, **self.headers, **headers}.items()]
        head = "\r\n".join([f"POST {path} HTTP/1.1", *lines, "", ""]).encode()
        line = socket.create_connection(("127.0.0.1", self._server.port), LONG_S)
        line.sendall(head + content)
        return line

    def send(
        self, path: str, content: bytes | None, length: int | None = None, **headers: str
    ) -> tuple[int, Any]:
        """Post a file: (status, answer)."""
        with self.line(path, content or b"", length, **headers) as line:
            answer = b""
            with contextlib.suppress(ConnectionResetError):
                while part := line.recv(65_536):
                    answer += part
        head, _, body = answer.partition(b"\r\n\r\n")
        return int(head.split()[1]), json.loads(body)

    def _ask(
        self, path: str, content: bytes | None, headers: dict[str, str]
    ) -> tuple[int, dict[str, str], bytes]:
        url = f"http://127.0.0.1:{self._server.port}{path}"
        request = urllib.request.Request(url, content, {**self.headers, **headers})
        try:
            with _OPENER.open(request, timeout=LONG_S) as response:
                return response.status, dict(response.headers), response.read()
        except urllib.error.HTTPError as error:
            return error.code, dict(error.headers), error.read()


class _Stay(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any) -> None:
        return None


_OPENER = urllib.request.build_opener(_Stay)


@pytest.fixture
def visitor(server: WebServer, desk: PairingDesk) -> Callable[..., Visitor]:
    """Makes visitors: visitor("caretaker"), visitor(None)."""

    def maker(role: str | None = "driver") -> Visitor:
        return Visitor(server, desk, role)

    return maker


@pytest.fixture
def driver(visitor: Callable[..., Visitor]) -> Visitor:
    """The driver's tablet."""
    return visitor("driver")


@pytest.fixture
def open_page(driver: Visitor) -> Callable[..., Page]:
    """Opens a WebSocket of the driver: open_page(path="/ws/control", **headers)."""
    return driver.open


@pytest.fixture
def get(driver: Visitor) -> Callable[..., tuple[int, dict[str, str], bytes]]:
    """Fetches a path as the driver: (status, headers, body)."""
    return driver.get
