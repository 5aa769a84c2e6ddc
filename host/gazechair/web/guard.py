"""WSGI middleware that decides which requests reach the application, by pure rules."""

from __future__ import annotations

import ipaddress
import json
import logging
import re
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from gazechair.base.throttled_log import ThrottledLog
from gazechair.people.pairing import Device
from gazechair.people.pairing.store import ROLES
from gazechair.web.handler import CONNECTION, EARLY, FILE, SETTLE
from gazechair.web.processor_share import Shares, write_off
from gazechair.web.websocket import Arrivals, BadHandshake, Line, handshake

Environ = dict[str, Any]
StartResponse = Callable[..., Any]

DEVICE = "gazechair.device"
_LIBRARY_SOCKET = "werkzeug.socket"  # where flask-sock looks for the connection
_PUBLIC = (
    *("/pair", "/me", "/authority.crt", "/static/pair.js", "/static/pair.css"),
    *("/static/icon.svg", "/static/strings.js", "/static/retry.js"),
)
_PUBLIC_FOLDER = "/strings/"
PAGES = ("/", "/caretaker")
_MOST_COOKIES = 200  # browsers keep fewer per host
_MOST_ARRIVALS = 100  # more than there are devices
_FILE_S = 3.0  # of a processor, for a large file at once
_TOKEN = re.compile(r"[A-Za-z0-9_-]{1,64}")

HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
        "connect-src 'self'; media-src 'self'; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Permissions-Policy": (
        "camera=(), microphone=(), geolocation=(), usb=(), serial=(), payment=(), "
        "screen-wake-lock=(self), autoplay=(self), gamepad=(self), fullscreen=(self)"
    ),
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}

throttled = ThrottledLog(logging.getLogger(__name__))


@dataclass(frozen=True)
class HttpRefusal:
    """An answer instead of the page: status, reason (a key of the string tables), one line."""

    status: str
    reason: str
    detail: str


def foreign(environ: Environ, names: frozenset[str], scheme: str) -> str | None:
    """Why a request comes from elsewhere, in one line; None when it may pass.

    The Host must be an IP address or one of our own `names` (lower case): a foreign name that
    points to us would give its page our origin (DNS rebinding). A request that can change
    anything, a socket or a POST, must come from this origin if the client is a browser and sends
    its origin.
    """
    host = str(environ.get("HTTP_HOST", "")).lower()
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        name = ""
    if name not in names and not _is_address(name):
        return f"Host {host!r} is not this machine; open the page by its IP address"
    if not _is_upgrade(environ) and environ.get("REQUEST_METHOD", "GET") in ("GET", "HEAD"):
        return None
    origin = environ.get("HTTP_ORIGIN")
    if origin is not None and str(origin).lower() != f"{scheme}://{host}":
        return f"Origin {origin!r} is another site than {scheme}://{host}"
    site = environ.get("HTTP_SEC_FETCH_SITE", "same-origin")
    if site not in ("same-origin", "none"):
        return f"the request comes from another site ({site})"
    return None


def _is_upgrade(environ: Environ) -> bool:
    """True for a request that wants to become a WebSocket."""
    return str(environ.get("HTTP_UPGRADE", "")).lower() == "websocket"


def is_public(path: str) -> bool:
    """True for the pairing page and the few files it needs."""
    return path in _PUBLIC or path.startswith(_PUBLIC_FOLDER)


def token_in(environ: Environ, cookie_name: str) -> str:
    """The device's token in the request's cookie, "" without one.

    Our own cookie contains nothing that needs quotes or escapes, so none are parsed: other cookies
    are never examined, and the time is linear in the header.
    """
    cookies = str(environ.get("HTTP_COOKIE", "")).split(";", _MOST_COOKIES)[:_MOST_COOKIES]
    for cookie in cookies:
        name, _, value = cookie.partition("=")
        if name.strip(" \t") == cookie_name:
            value = value.strip(" \t")
            return value if _TOKEN.fullmatch(value) else ""
    return ""


class Guard:
    """Admits paired devices from this site: to a socket directly, to the rest in turns."""

    def __init__(
        self,
        app: Callable[..., Iterable[bytes]],
        sockets: Collection[str],
        names: frozenset[str],
        who: Callable[[str], Device | None],
        cookie_name: Callable[[], str],
        scheme: str,
        strangers: Shares,
    ) -> None:
        """`sockets`: the paths that `app` serves as WebSockets; `who` gives a token's device;
        `scheme`: "http" or "https"; `strangers`: the share of unknown clients."""
        self._app = app
        self._sockets = sockets
        self._names = names
        self._who = who
        self._cookie_name = cookie_name
        self._scheme = scheme
        self._strangers = strangers
        self._shares = {role: Shares(at_once=2) for role in ROLES}
        self._files = Shares(burst_s=_FILE_S)
        self._arrivals: dict[str, Arrivals] = {}

    def __call__(self, environ: Environ, start_response: StartResponse) -> Iterable[bytes]:
        """WSGI. Raises ConnectionAbortedError after a socket's end: there is no answer to send.
        Raises Crowded when too many requests are waiting."""

        def start(status: str, headers: list[tuple[str, str]], *more: Any) -> Any:
            sent = {name.lower() for name, _ in headers}
            strict = [pair for pair in HEADERS.items() if pair[0].lower() not in sent]
            return start_response(status, headers + strict, *more)

        path = str(environ.get("PATH_INFO", ""))
        with self._strangers.turn():
            refusal = self._judge(environ)
            if refusal is not None:
                if refusal.reason == "not_paired" and path in PAGES and not _is_upgrade(environ):
                    return _redirect(environ, start, "/pair")
                throttled.warn(
                    "refused %s %.80r: %s", environ.get("REMOTE_ADDR"), path, refusal.detail
                )
                return _answer(start, refusal)
        # A change may wait for the disk: it holds up neither pages nor sockets.
        kind = str(environ.get("REQUEST_METHOD"))
        device: Device | None = environ[DEVICE]
        if device is None:
            with self._strangers.turn(kind=kind):
                return self._whole(environ, start)
        if path in self._sockets:
            return self._socket(environ, start, device)
        if _is_upgrade(environ):
            detail = "no WebSocket is at this address"
            return _answer(start, HttpRefusal("400 Bad Request", "bad_message", detail))
        if FILE in environ and device.role == "caretaker":
            # One file at a time; other requests of this role continue meanwhile.
            with self._files.turn():
                environ[SETTLE](f"file {device.id}")
                refusal = self._judge(environ)  # it may just have been revoked
                if refusal is not None:
                    return _answer(start, refusal)
                environ[FILE]()
                return self._whole(environ, start)
        with self._shares[device.role].turn(kind=kind):
            return self._whole(environ, start)

    def _whole(self, environ: Environ, start: StartResponse) -> Iterable[bytes]:
        # The answer is computed inside a turn and sent outside, so a slow reader delays nobody.
        body = self._app(environ, start)
        try:
            return [b"".join(body)]
        finally:
            getattr(body, "close", lambda: None)()

    def _socket(self, environ: Environ, start: StartResponse, device: Device) -> Iterable[bytes]:
        arrivals = self._arrivals.setdefault(device.id, Arrivals())
        while len(self._arrivals) > _MOST_ARRIVALS:
            self._arrivals.pop(next(iter(self._arrivals)), None)
        with self._shares[device.role].turn():
            try:
                checked = handshake(environ)
            except BadHandshake as error:
                return _answer(start, HttpRefusal("400 Bad Request", "bad_message", str(error)))
            if not arrivals.allow_opening():
                detail = "this device opens too many sockets, or says too much on them"
                return _answer(start, HttpRefusal("429 Too Many Requests", "too_fast", detail))
        connection = environ[CONNECTION]
        # The deadline for a request must not end a socket that is quiet for a while.
        connection.raw.settimeout(None)
        line = Line(connection, arrivals, environ[EARLY])
        try:
            answer = self._whole(checked | {_LIBRARY_SOCKET: line}, start)
        finally:
            write_off()  # a socket has its own limits
        if line.opened:
            raise ConnectionAbortedError
        return answer

    def _judge(self, environ: Environ) -> HttpRefusal | None:
        reason = foreign(environ, self._names, self._scheme)
        if reason is not None:
            return HttpRefusal("403 Forbidden", "not_allowed", reason)
        device = self._who(token_in(environ, self._cookie_name()))
        environ[DEVICE] = device
        if device is None and not is_public(str(environ.get("PATH_INFO", ""))):
            detail = "this device is not paired with this chair; open /pair"
            return HttpRefusal("401 Unauthorized", "not_paired", detail)
        return None


def _answer(start: StartResponse, refusal: HttpRefusal) -> Iterable[bytes]:
    text = json.dumps({"reason": refusal.reason, "detail": refusal.detail}).encode() + b"\n"
    headers = [
        ("Content-Type", "application/json"),
        ("Content-Length", str(len(text))),
        ("Cache-Control", "no-store"),
    ]
    start(refusal.status, headers)
    return [text]


def _redirect(environ: Environ, start: StartResponse, path: str) -> Iterable[bytes]:
    query = environ.get("QUERY_STRING", "")
    where = f"{path}?{query}" if query else path
    start(
        "303 See Other",
        [("Location", where), ("Content-Length", "0"), ("Cache-Control", "no-store")],
    )
    return [b""]


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
