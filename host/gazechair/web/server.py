"""The web server: Flask and flask-sock behind strict middleware, one thread per connection."""

from __future__ import annotations

import errno
import logging
import socket
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flask import Flask, Response, request
from flask_sock import Sock
from werkzeug.exceptions import HTTPException

from gazechair.base.latest_value import Latest
from gazechair.base.throttled_log import ThrottledLog
from gazechair.base.user_error import UserError
from gazechair.board.caretaker_settings import CaretakerSettings
from gazechair.config.settings import Config, is_loopback, uses_tls
from gazechair.driving.driver_port import DriverPort
from gazechair.people.pairing import Device, PairingDesk
from gazechair.picture.camera import Frame
from gazechair.web import (
    alert_routes,
    files,
    first_drive_routes,
    map_routes,
    pairing_routes,
    profile_routes,
    settings_routes,
)
from gazechair.web.answers import HttpRefused, answer, refuse
from gazechair.web.certificate import Certificate, CertificateError
from gazechair.web.control_sockets import ControlHub
from gazechair.web.guard import DEVICE, Guard
from gazechair.web.handler import SETTLE, Server
from gazechair.web.names import certificate_names, network_addresses, own_names, shown_host
from gazechair.web.picture_sockets import PictureHub
from gazechair.web.processor_share import Shares
from gazechair.web.websocket import LIBRARY_OPTIONS, WebSocket

_CONTROL = "/ws/control"
_PICTURE = "/ws/video"

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)


class WebError(UserError):
    """Raised when the server can't start; one plain line: what, where, what to do."""


@dataclass(frozen=True)
class PageParts:
    """The parts of the daemon that the pages show and change."""

    port: DriverPort
    pictures: Latest[Frame] | None
    """The slot of the newest; None without a camera."""
    settings: CaretakerSettings
    alerts: alert_routes.AlertBook
    steps: first_drive_routes.Steps
    maps: map_routes.Maps


class WebServer:
    """Serves the pages on config.web's address, on its own threads."""

    def __init__(self, config: Config, parts: PageParts, desk: PairingDesk, folder: Path) -> None:
        """`folder`: for state."""
        self._config = config
        self._parts = parts
        self._desk = desk
        self._folder = folder
        self._tls = uses_tls(config.web)
        insecure = not self._tls and not is_loopback(config.web.host)
        self._control = ControlHub(parts.port, desk.is_paired, insecure)
        self._pictures = PictureHub(parts.pictures)
        self._server: Server | None = None
        self._thread: threading.Thread | None = None
        desk.on_revoke(self._revoked)

    @property
    def port(self) -> int:
        """The TCP port it listens on (chosen by the system when configured as 0)."""
        return self._server.port if self._server else self._config.web.port

    @property
    def url(self) -> str:
        """The pages' address as other devices reach it, ending in a slash."""
        return f"{self._scheme}://{shown_host(self._config.web)}:{self.port}/"

    @property
    def _scheme(self) -> str:
        return "https" if self._tls else "http"

    def start(self) -> None:
        """Listen. Raises WebError when the address is taken, files or a certificate are missing."""
        web = self._config.web
        self._certificate = None
        # Before the certificate, which names this address for years.
        listener = _listen(web.host, web.port)
        try:
            app = self._application()
            if self._tls:
                self._certificate = Certificate(self._folder, certificate_names(web))
            context = self._certificate.context() if self._certificate else None
            names = own_names(web.host, web.name)
            strangers = Shares()
            guarded = Guard(
                app,
                (_CONTROL, _PICTURE),
                names,
                self._desk.who,
                self._cookie_name,
                self._scheme,
                strangers,
            )
            self._server = Server(listener, guarded, strangers, context)
        except (FileNotFoundError, CertificateError) as error:
            raise WebError(str(error)) from error
        finally:
            listener.close()  # the server works on its own duplicate
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="web-accept", daemon=True
        )
        self._control.start()
        self._thread.start()
        log.info("serving the pages at %s", self.url)

    def stop(self) -> None:
        """Cut every connection and end every thread. Safe to call when start failed."""
        if self._server is None or self._thread is None:
            return
        self._server.shutdown()
        self._thread.join(5.0)
        self._server.server_close()
        self._control.stop()
        self._pictures.stop()
        self._server = None

    def _revoked(self, device_id: str) -> None:
        self._control.revoked(device_id)
        if self._server is not None:
            for what in ("picture", "file"):
                self._server.connections.cut_settled(f"{what} {device_id}")

    def _cookie_name(self) -> str:
        # Browsers send a cookie to every port of a host: two hosts on one machine must differ.
        prefix = "__Host-" if self._tls else ""
        return f"{prefix}gazechair-{self.port}"

    def _application(self) -> Flask:
        app = Flask("gazechair", static_folder=None)
        app.config["SOCK_SERVER_OPTIONS"] = LIBRARY_OPTIONS
        files.add_routes(app, files.web_folder())
        pairing_routes.add_routes(
            app, self._desk, self._cookie_name, lambda: f"{self.url}pair", self._tls
        )
        parts = self._parts
        profile_routes.add_routes(app, parts.port)
        settings_routes.add_routes(app, parts.settings, parts.steps)
        alert_routes.add_routes(app, parts.alerts)
        first_drive_routes.add_routes(app, parts.steps)
        map_routes.add_routes(app, parts.maps)
        sock = Sock(app)

        @app.get("/health")
        def health() -> Response:
            return answer(parts.port.health())

        @app.get("/authority.crt")
        def authority() -> Response:
            if self._certificate is None:
                return refuse(404, "not_connected", "this host does not encrypt")
            text = self._certificate.authority.read_bytes()
            return Response(text, mimetype="application/x-x509-ca-cert")

        @app.errorhandler(HttpRefused)
        def refused(error: HttpRefused) -> Response:
            return error.response()

        @app.errorhandler(HTTPException)
        def failed(error: HTTPException) -> Response:
            return refuse(error.code or 500, "bad_message", f"{error.code} {error.name}")

        @app.errorhandler(Exception)
        def broken(_: Exception) -> Response:
            throttled.warn("error in an answer", exc_info=True)
            return refuse(500, "bad_message", "an error of the host; its log tells more")

        @sock.route(_CONTROL)  # type: ignore[untyped-decorator]
        def control_socket(library: Any) -> None:
            device = _settle("control")
            self._control.serve(WebSocket(library), _peer(), device)

        @sock.route(_PICTURE)  # type: ignore[untyped-decorator]
        def picture_socket(library: Any) -> None:
            device = _settle("picture")
            if self._desk.is_paired(device.id):
                self._pictures.serve(WebSocket(library), _peer(), device)

        return app


def _settle(what: str) -> Device:
    # The connection is now a paired device's socket: no deadline, and revocation can find it.
    device: Device = request.environ[DEVICE]
    request.environ[SETTLE](f"{what} {device.id}")
    return device


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
            listener.listen(1024)  # a burst must not make a driver wait a second for the next try
        except OSError:
            listener.close()
            raise
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or "no address"
        raise WebError(
            f"can't serve the page at {host}:{port} ({reason}); {_advice(error)}"
        ) from error
    return listener


def _advice(error: OSError | UnicodeError) -> str:
    number = None if isinstance(error, socket.gaierror) else getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return "end the other program there, or choose another web.port"
    if number == errno.EACCES:
        return "choose a web.port of 1024 or more"
    addresses = ", ".join(("127.0.0.1", *network_addresses()))
    return f"web.host must be an address of this machine ({addresses}), or 0.0.0.0 for all of them"
