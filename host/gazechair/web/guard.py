"""The door: which requests reach the application at all. WSGI middleware and its pure rules."""

from __future__ import annotations

import ipaddress
import json
import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import urlsplit

from gazechair.pairing import Device
from gazechair.web.complaints import Complaints

Environ = dict[str, Any]
StartResponse = Callable[..., Any]

UPGRADED = "gazechair.upgraded"
DEVICE = "gazechair.device"
_PUBLIC = ("/pair", "/me", "/authority.crt", "/static/pair.js", "/static/pair.css")
_PUBLIC_TOO = ("/static/icon.svg", "/static/strings.js")
_PUBLIC_FOLDER = "/strings/"
PAGES = ("/", "/caretaker")

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

complaints = Complaints(logging.getLogger(__name__))


@dataclass(frozen=True)
class Refusal:
    """An answer instead of the page: status, reason (a key of the string tables), one line."""

    status: str
    reason: str
    detail: str


def foreign(environ: Environ, names: frozenset[str], scheme: str) -> str | None:
    """Why a request comes from elsewhere, one plain line; None when it may pass.

    The Host must be an IP address or one of our own `names` (lower case): a foreign name that was
    made to point at us would give its page our origin (DNS rebinding). What can change anything, a
    socket or a POST, must come from this very origin where the client is a browser and so says.
    """
    host = str(environ.get("HTTP_HOST", "")).lower()
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        name = ""
    if name not in names and not _is_address(name):
        return f"Host {host!r} is not this machine; open the page by its IP address"
    if not is_upgrade(environ) and environ.get("REQUEST_METHOD", "GET") in ("GET", "HEAD"):
        return None
    origin = environ.get("HTTP_ORIGIN")
    if origin is not None and str(origin).lower() != f"{scheme}://{host}":
        return f"Origin {origin!r} is another site than {scheme}://{host}"
    site = environ.get("HTTP_SEC_FETCH_SITE", "same-origin")
    if site not in ("same-origin", "none"):
        return f"the request comes from another site ({site})"
    return None


def is_upgrade(environ: Environ) -> bool:
    """True for a request that wants to become a WebSocket."""
    return str(environ.get("HTTP_UPGRADE", "")).lower() == "websocket"


def is_public(path: str) -> bool:
    """True for the pairing page and the few files it needs."""
    return path in _PUBLIC or path in _PUBLIC_TOO or path.startswith(_PUBLIC_FOLDER)


def token_in(environ: Environ, cookie_name: str) -> str:
    """The device's token in the request's cookie, "" without one."""
    try:
        cookie = SimpleCookie(str(environ.get("HTTP_COOKIE", ""))).get(cookie_name)
    except CookieError:
        return ""
    return "" if cookie is None else cookie.value


class Guard:
    """Lets in who is paired, from this very site; prepares the connection of a socket."""

    def __init__(
        self,
        app: Callable[..., Iterable[bytes]],
        names: frozenset[str],
        who: Callable[[str], Device | None],
        cookie_name: Callable[[], str],
        scheme: str,
    ) -> None:
        """`who` tells whose token it is; `scheme`: "http" or "https"."""
        self._app = app
        self._names = names
        self._who = who
        self._cookie_name = cookie_name
        self._scheme = scheme

    def __call__(self, environ: Environ, start_response: StartResponse) -> Iterable[bytes]:
        """WSGI. Raises ConnectionAbortedError after a socket's end: there is nobody to answer."""

        def start(status: str, headers: list[tuple[str, str]], *more: Any) -> Any:
            told = {name.lower() for name, _ in headers}
            strict = [pair for pair in HEADERS.items() if pair[0].lower() not in told]
            return start_response(status, headers + strict, *more)

        refusal = self._judge(environ)
        path = str(environ.get("PATH_INFO", ""))
        if refusal is not None:
            if refusal.reason == "not_paired" and path in PAGES and not is_upgrade(environ):
                return _redirect(environ, start, "/pair")
            complaints.warn("refused %s %r: %s", environ.get("REMOTE_ADDR"), path, refusal.detail)
            return _answer(start, refusal)
        # Compression would cost 1 ms a picture and gain nothing (a JPEG does not shrink).
        environ.pop("HTTP_SEC_WEBSOCKET_EXTENSIONS", None)
        if is_upgrade(environ):
            # The deadline for request headers must not end a socket that is quiet for a while.
            environ["werkzeug.socket"].settimeout(None)
        body = self._app(environ, start)
        if environ.get(UPGRADED):
            raise ConnectionAbortedError
        return body

    def _judge(self, environ: Environ) -> Refusal | None:
        reason = foreign(environ, self._names, self._scheme)
        if reason is not None:
            return Refusal("403 Forbidden", "not_allowed", reason)
        device = self._who(token_in(environ, self._cookie_name()))
        environ[DEVICE] = device
        if device is None and not is_public(str(environ.get("PATH_INFO", ""))):
            detail = "this device is not paired with this chair; open /pair"
            return Refusal("401 Unauthorized", "not_paired", detail)
        return None


def _answer(start: StartResponse, refusal: Refusal) -> Iterable[bytes]:
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
