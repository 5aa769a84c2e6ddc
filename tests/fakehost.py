"""A small stand-in for the host: serves the pages, sends what a test sets, records all messages."""

import contextlib
import functools
import io
import json
import socket
import struct
import tempfile
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from flask import Flask, Response, jsonify, request, send_from_directory
from flask_sock import Sock
from PIL import Image, ImageDraw
from simple_websocket import ConnectionClosed, Server
from werkzeug.serving import ThreadedWSGIServer, WSGIRequestHandler
from wsproto.events import CloseConnection
from wsproto.utilities import LocalProtocolError

import gazesetup
from gazeboard.core import limits
from gazechair.driving.control import HEARTBEAT_MS
from gazechair.driving.messages import MAX_SINCE_MS
from gazechair.people.profiles import ProfileRefused, Profiles, fields
from gazechair.web.guard import HEADERS
from gazechair.web.minify import minified
from gazelink import codes
from patience import PATIENCE_S, wait_until

WEB = gazesetup.ROOT / "web"
KINDS = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
CONTENT_POLICY = HEADERS["Content-Security-Policy"]
WELCOME = {
    "k": "welcome",
    "role": "driver",
    "name": "tablet",
    "simulated": False,
    "insecure": False,
    "backward": False,
    "heartbeat_ms": HEARTBEAT_MS,
    "token_ms": MAX_SINCE_MS,
    "command_ttl_ms": limits.COMMAND_TTL_MS,
    "modes": [],
    "plugins": [],
    "latched": [name for _, name, _, latched in codes.FAULTS if latched],
}
ARMED = {
    "k": "state",
    "state": "armed",
    "motion": "stopped",
    "override": "none",
    "arm_reason": "none",
    "decisions": dict.fromkeys(("forward", "backward", "left", "right"), "free"),
    "level": "ok",
    "message": "ok",
    "board": "ok",
    "lidar": "ok",
    "camera": "ok",
    "owner": "driver",
    "you": True,
    "auto": ["", ""],
    "edge": 0,
    "heading_deg": 0.0,
    "output_permille": [0, 0],
    "cap_permille": 1000,
    "bypass_ms": 0,
    "call": False,
    "simulated": False,
}
# Changes of ARMED while driving is off.
OFF = {"state": "disarmed", "you": False, "owner": "nobody"}


@functools.cache
def picture(width: int = 1280, height: int = 720, shade: int = 0) -> bytes:
    """A JPEG of a bright corridor, so that screenshots show the page over a camera picture."""
    image = Image.new("RGB", (width, height), (226 - shade, 222 - shade, 210 - shade))
    draw = ImageDraw.Draw(image)
    x, y = width // 2, int(height * 0.42)
    draw.polygon([(0, height), (width, height), (x + 130, y + 60), (x - 130, y + 60)], "#a98c66")
    draw.rectangle([x - 130, y - 130, x + 130, y + 60], fill="#cfd6d8")
    draw.rectangle([x - 50, y - 90, x + 50, y + 60], fill="#7d5a3c")
    for side in (-1, 1):
        draw.line([(x + side * 130, y - 130), (x + side * width, -300)], "#b7b2a4", 4)
        draw.line([(x + side * 130, y + 60), (x + side * x, height)], "#8d8775", 4)
    out = io.BytesIO()
    image.save(out, "JPEG", quality=80)
    return out.getvalue()


@functools.cache
def _file(path: str) -> tuple[str, bytes] | None:
    """The kind and the bytes of a file under this path of the address, if there is one."""
    folder, _, name = path.lstrip("/").partition("/")
    if folder == "static" and (WEB / name).is_file():
        kind = Path(name).suffix
        text = minified((WEB / name).read_text("utf-8"), kind)
        return f"{KINDS[kind]}; charset=utf-8", text.encode()
    if folder == "strings" and (WEB / folder / name).is_file():
        return "application/json", (WEB / folder / name).read_bytes()
    return None


class Requests(WSGIRequestHandler):
    """Sends files from memory, on connections that stay open; the application does the rest.

    A page loads about 40 files, and the tests load a page some hundred times: a browser may keep
    them, which the host does not allow.
    """

    protocol_version = "HTTP/1.1"
    wbufsize = -1  # an answer is one packet

    def run_wsgi(self) -> None:
        file = _file(self.path.partition("?")[0]) if self.command == "GET" else None
        if file is None:
            super().run_wsgi()
            self.close_connection = True  # it may have been a WebSocket
            return
        kind, data = file
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "max-age=3600")
        self.send_header("Content-Security-Policy", CONTENT_POLICY)
        self.end_headers()
        self.wfile.write(data)

    def log_request(self, code: int | str = "-", size: int | str = "-") -> None:
        """Nobody reads it."""


class WebServer(ThreadedWSGIServer):
    """Knows what is connected to it, so that nothing is any more when it has ended."""

    def __init__(self, app: Callable[..., Any], listener: socket.socket | None) -> None:
        self._open: set[socket.socket] = set()
        fd = None if listener is None else listener.fileno()
        super().__init__("127.0.0.1", 0, app, Requests, fd=fd)

    def process_request(self, request: socket.socket, client_address: Any) -> None:
        self._open.add(request)
        super().process_request(request, client_address)

    def shutdown_request(self, request: socket.socket) -> None:
        self._open.discard(request)
        super().shutdown_request(request)

    def server_close(self) -> None:
        for connection in [*self._open]:
            with contextlib.suppress(OSError):  # its thread may have been quicker
                connection.shutdown(socket.SHUT_RDWR)
        super().server_close()


def _ended(app: Flask) -> Callable[..., Any]:
    """The application; sends no HTTP answer on a connection that was a WebSocket."""

    def wsgi(environ: dict[str, Any], start_response: Callable[..., Any]) -> Any:
        body = app(environ, start_response)
        if "HTTP_UPGRADE" in environ:
            raise ConnectionAbortedError
        return body

    return wsgi


class FakeHost:
    """Serves the real page; the test sends as the host would, and reads what the page sends.

    `listener`: the socket at which it takes connections; None: one of its own.
    """

    def __init__(self, listener: socket.socket | None = None) -> None:
        self.welcome: dict[str, Any] = dict(WELCOME)
        self.state: dict[str, Any] = dict(ARMED)
        self.received: list[dict[str, Any]] = []
        self.acknowledged: list[str] = []
        self.accepting = True
        self.token = 0
        self.now_ms = 0  # follows the page's clock
        self.replies: dict[str, tuple[int, dict[str, Any]]] = {}  # "GET /me": status, body
        self.pictures: dict[str, bytes] = {}  # of maps
        self.files: list[bytes] = []  # what was posted as one
        self.posted: list[tuple[str, dict[str, Any]]] = []
        self._marks = 0
        self._shown: tuple[str, bytes] | None = None  # the newest picture: its number, the message
        self._close_code = 0
        self._folder = tempfile.TemporaryDirectory(prefix="gazechair-")
        table = fields(["en", "nl", "xx"], {"mode": "continuous"})
        self.profiles = Profiles(Path(self._folder.name), table)
        self._sockets: dict[str, list[Server]] = {"control": [], "video": []}
        self._lock = threading.Lock()
        self._server = WebServer(_ended(self._application()), listener)
        self._stopped = False
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}/"
        self._thread = threading.Thread(target=self._listen, name="fake host")
        self._thread.start()

    def _listen(self) -> None:
        """Takes connections until it is stopped, which a last connection tells it."""
        while not self._stopped:
            self._server.handle_request()

    def _application(self) -> Flask:
        app = Flask("fakehost", static_folder=None)
        app.json.sort_keys = False  # type: ignore[attr-defined]
        sock = Sock(app)

        @app.get("/")
        def page() -> Response:
            return send_from_directory(WEB, "index.html")

        @app.get("/<any(caretaker, pair):name>")
        def other_page(name: str) -> Response:
            return send_from_directory(WEB, f"{name}.html")

        @app.get("/profiles")
        def profiles() -> Response:
            return jsonify(self.profiles.as_json())

        @app.post("/profiles")
        def change_profile() -> tuple[Response, int]:
            try:
                role = self.welcome["role"]
                return jsonify(self.profiles.change(request.get_json(), role == "caretaker")), 200
            except ProfileRefused as refusal:
                return jsonify({"reason": refusal.reason, "detail": str(refusal)}), 400
            finally:  # a test that waits for it finds it complete
                self.posted.append(("/profiles", request.get_json()))

        @app.get("/maps/<name>.png")
        def map_picture(name: str) -> Response:
            return Response(self.pictures[name], mimetype="image/png")

        @app.get("/<any(me, settings, pairing, alerts, maps, 'first-drive'):name>")
        def read(name: str) -> tuple[Response, int]:
            return self._reply(f"GET /{name}")

        @app.get("/maps/<name>")
        def read_map(name: str) -> tuple[Response, int]:
            return self._reply(f"GET /maps/{name}")

        @app.post("/maps/import")
        def take_file() -> tuple[Response, int]:
            assert request.mimetype == "application/zip"
            self.files.append(request.get_data())
            return self._reply("POST /maps/import")

        @app.post("/<path:path>")
        def write(path: str) -> tuple[Response, int]:
            self.posted.append((f"/{path}", request.get_json()))
            return self._reply(f"POST /{path}")

        @app.after_request
        def strict(answer: Response) -> Response:
            answer.headers["Content-Security-Policy"] = CONTENT_POLICY
            answer.headers.setdefault("Cache-Control", "no-store")
            return answer

        @sock.route("/ws/control")
        def control(ws: Server) -> None:
            self._serve(ws, "control", lambda text: self.received.append(json.loads(text)))

        @sock.route("/ws/video")
        def video(ws: Server) -> None:
            self._serve(ws, "video", self.acknowledged.append)

        return app

    def _reply(self, name: str) -> tuple[Response, int]:
        status, body = self.replies.get(name, (404, {"reason": "unknown", "detail": "no reply"}))
        return jsonify(body), status

    def _serve(self, ws: Server, kind: str, hear: Callable[[str], None]) -> None:
        if not self.accepting:
            return
        with self._lock:
            if kind == "control":
                ws.send(json.dumps(self.welcome))
            elif self._shown is not None and self._shown[0] not in self.acknowledged:
                ws.send(self._shown[1])  # the newest, as the host does
            self._sockets[kind].append(ws)
        try:
            while not (kind == "control" and self._close_code):
                message = ws.receive(0.1)
                if message is not None:
                    hear(message)
            with contextlib.suppress(LocalProtocolError):  # the page has just closed it
                ws.sock.send(ws.ws.send(CloseConnection(self._close_code)))
            ws.sock.shutdown(socket.SHUT_RDWR)  # otherwise its reader keeps it open
        finally:
            with self._lock:
                self._sockets[kind].remove(ws)

    def say(self, message: dict[str, Any]) -> None:
        self._send("control", json.dumps(message))

    def say_state(self, **changes: Any) -> int:
        """Sends the state with these changes and a fresh token; returns the token."""
        self.state.update(changes)
        self._send("control", self.coming_state(0))
        return self.token

    def coming_state(self, in_ms: int) -> str:
        """The state as the host would send it after `in_ms`, with a fresh token."""
        self.token = max(self.token + 1, self.now_ms + in_ms)
        return json.dumps({**self.state, "token": self.token, "profile": self.profiles.revision})

    def show(self, jpeg: bytes, sequence: int, age_ms: int = 0) -> None:
        message = struct.pack("<II", sequence, age_ms) + jpeg
        with self._lock:
            self._shown = str(sequence), message
            self._send_to("video", message)

    def connected(self, kind: str) -> bool:
        return bool(self._sockets[kind])

    def close(self, code: int) -> None:
        """Closes the control sockets with this code."""
        self._close_code = code
        wait_until(lambda: not self.connected("control"), "the sockets to close")
        self._close_code = 0

    def cut(self) -> None:
        """Closes every socket and accepts no new one, like a host that died."""
        self.accepting = False
        for ws in [*self._sockets["control"], *self._sockets["video"]]:
            # The page may have been quicker.
            with contextlib.suppress(ConnectionClosed, LocalProtocolError, OSError):
                ws.close()
        wait_until(lambda: not self.connected("control"), "the sockets to close")

    def _send(self, kind: str, data: str | bytes) -> None:
        with self._lock:
            self._send_to(kind, data)

    def _send_to(self, kind: str, data: str | bytes) -> None:
        for ws in self._sockets[kind]:
            try:
                ws.send(data)
            except (ConnectionClosed, LocalProtocolError):
                continue  # its own thread takes it off the list

    def stop(self) -> None:
        self.cut()
        self._stopped = True
        socket.create_connection(self._server.server_address).close()
        self._thread.join(PATIENCE_S)
        self._server.server_close()
        self._folder.cleanup()
