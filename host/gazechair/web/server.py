"""The web server: Flask and flask-sock under Werkzeug, a thread a connection, all bounded."""

from __future__ import annotations

import json
import logging
import socket
import threading
from typing import Any

from flask import Flask, Response, request
from flask_sock import Sock
from werkzeug.serving import ThreadedWSGIServer, WSGIRequestHandler

from gazechair.camera import Frame
from gazechair.config import Config
from gazechair.driver_port import DriverPort
from gazechair.slots import Latest
from gazechair.web import files
from gazechair.web.control import ControlHub
from gazechair.web.guard import UPGRADED, Guard, own_names
from gazechair.web.sockets import ReaderThread, tune
from gazechair.web.video import VideoHub

MAX_CONNECTIONS = 64
_HEADERS_S = 5.0
# Above this a socket is closed; a control message above 256 bytes is refused in words first.
_MAX_SOCKET_MESSAGE = 1024

log = logging.getLogger(__name__)


class WebError(Exception):
    """The server can't start; the text is one plain line: what, where, what to do."""


class WebServer:
    """Serves the driver's page on config.web's address from threads of its own."""

    def __init__(self, config: Config, port: DriverPort, video: Latest[Frame] | None) -> None:
        """`video`: the slot with the newest picture, None without a camera."""
        self._config = config
        self._driver_port = port
        self._control = ControlHub(port)
        self._video = VideoHub(video)
        self._server: _Server | None = None
        self._thread: threading.Thread | None = None

    @property
    def port(self) -> int:
        """The TCP port it listens on (chosen by the system when configured as 0)."""
        return self._server.port if self._server else self._config.web.port

    def start(self) -> None:
        """Listen. Raises WebError when the address is taken or the page's files are missing."""
        try:
            app = self._application()
        except FileNotFoundError as error:
            raise WebError(str(error)) from error
        listener = _listen(self._config.web.host, self._config.web.port)
        try:
            guarded = Guard(app, own_names(self._config.web.host))
            self._server = _Server(listener, guarded)
        finally:
            listener.close()  # the server works on its own duplicate
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="web-accept", daemon=True
        )
        self._control.start()
        self._thread.start()
        log.info("serving the driver's page at http://%s:%d/", self._config.web.host, self.port)

    def stop(self) -> None:
        """Cut every connection and end every thread. Safe to call when start failed."""
        if self._server is None or self._thread is None:
            return
        self._server.shutdown()
        self._thread.join(5.0)
        self._server.server_close()
        self._control.stop()
        self._video.stop()
        self._server = None

    def _application(self) -> Flask:
        app = Flask("gazechair", static_folder=None)
        app.config["MAX_CONTENT_LENGTH"] = 1024
        app.config["SOCK_SERVER_OPTIONS"] = {
            "max_message_size": _MAX_SOCKET_MESSAGE,
            "thread_class": ReaderThread,
        }
        files.add_routes(app, files.web_folder())
        sock = Sock(app)

        @app.get("/health")
        def health() -> Response:
            body = json.dumps(self._driver_port.health(), indent=1) + "\n"
            response = Response(body, mimetype="application/json")
            response.headers["Cache-Control"] = "no-store"
            return response

        @sock.route("/ws/control")  # type: ignore[untyped-decorator]
        def control_socket(ws: Any) -> None:
            request.environ[UPGRADED] = True
            self._control.serve(ws, _peer())

        @sock.route("/ws/video")  # type: ignore[untyped-decorator]
        def video_socket(ws: Any) -> None:
            request.environ[UPGRADED] = True
            self._video.serve(ws, _peer())

        return app


def _peer() -> str:
    return f"{request.environ.get('REMOTE_ADDR')}:{request.environ.get('REMOTE_PORT')}"


def _listen(host: str, port: int) -> socket.socket:
    # Bound here because Werkzeug ends the whole process when the port is taken.
    try:
        family, kind, _, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        listener = socket.socket(family, kind)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(address)
            listener.listen(32)
        except OSError:
            listener.close()
            raise
    except OSError as error:
        raise WebError(
            f"can't serve the page at {host}:{port} ({error.strerror}); "
            "end the other program there, or choose another web.port"
        ) from error
    return listener


class _Handler(WSGIRequestHandler):
    timeout = _HEADERS_S  # for request headers; a socket's upgrade removes it

    def setup(self) -> None:
        threading.current_thread().name = f"web-request-{self.client_address[1]}"
        tune(self.request)
        super().setup()

    def version_string(self) -> str:
        return "gazechair"

    def connection_dropped(self, error: BaseException, environ: Any = None) -> None:
        # Else what a closed socket's client still sent would be read as a next HTTP request.
        self.close_connection = True

    def log_request(self, code: int | str = "-", size: int | str = "-") -> None:
        log.debug("%s %s %s", self.client_address[0], self.requestline, code)

    def log(self, type: str, message: str, *args: Any) -> None:
        log.warning("%s: %s", self.client_address[0], message % args)


class _Server(ThreadedWSGIServer):
    def __init__(self, listener: socket.socket, app: Any) -> None:
        host, port = listener.getsockname()[:2]
        super().__init__(host, port, app, handler=_Handler, fd=listener.fileno())
        self._places = threading.BoundedSemaphore(MAX_CONNECTIONS)

    def verify_request(self, request: Any, client_address: Any) -> bool:
        if self._places.acquire(blocking=False):
            return True
        log.warning("refused %s: %d connections are open", client_address[0], MAX_CONNECTIONS)
        return False

    def process_request_thread(self, request: Any, client_address: Any) -> None:
        try:
            super().process_request_thread(request, client_address)
        finally:
            self._places.release()
