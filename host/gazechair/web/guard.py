"""The door: which requests reach the application at all. WSGI middleware and its pure rules."""

from __future__ import annotations

import ipaddress
import logging
import socket
from collections.abc import Callable, Iterable
from typing import Any
from urllib.parse import urlsplit

Environ = dict[str, Any]
StartResponse = Callable[..., Any]

UPGRADED = "gazechair.upgraded"

log = logging.getLogger(__name__)


def refusal(environ: Environ, names: frozenset[str]) -> str | None:
    """Why a request is not let in, one plain line; None when it may pass.

    The Host must be an IP address or one of our own `names` (lower case): a foreign name that was
    made to point at us would give its page our origin (DNS rebinding). A socket's Origin, when the
    client is a browser and so sends one, must be this very host.
    """
    host = str(environ.get("HTTP_HOST", "")).lower()
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        name = ""
    if name not in names and not _is_address(name):
        return f"Host {host!r} is not this machine; open the page by its IP address"
    origin = environ.get("HTTP_ORIGIN")
    if is_upgrade(environ) and origin is not None:
        parts = str(origin).lower().partition("://")
        if parts[0] not in ("http", "https") or parts[2] != host:
            return f"Origin {origin!r} is another site than {host!r}"
    return None


def own_names(configured: str) -> frozenset[str]:
    """Names under which this machine is reached, lower case."""
    host = socket.gethostname().lower()
    return frozenset({"localhost", host, f"{host}.local", configured.lower()} - {""})


def is_upgrade(environ: Environ) -> bool:
    """True for a request that wants to become a WebSocket."""
    return str(environ.get("HTTP_UPGRADE", "")).lower() == "websocket"


class Guard:
    """Lets in what `refusal` allows, and prepares the connection of a socket."""

    def __init__(self, app: Callable[..., Iterable[bytes]], names: frozenset[str]) -> None:
        self._app = app
        self._names = names

    def __call__(self, environ: Environ, start_response: StartResponse) -> Iterable[bytes]:
        """WSGI. Raises ConnectionAbortedError after a socket's end: there is nobody to answer."""
        reason = refusal(environ, self._names)
        if reason is not None:
            log.warning("refused %s: %s", environ.get("REMOTE_ADDR"), reason)
            start_response("403 Forbidden", [("Content-Type", "text/plain; charset=utf-8")])
            return [reason.encode() + b"\n"]
        # Compression would cost 1 ms a picture and gain nothing (a JPEG does not shrink).
        environ.pop("HTTP_SEC_WEBSOCKET_EXTENSIONS", None)
        if is_upgrade(environ):
            # The deadline for request headers must not end a socket that is quiet for a while.
            environ["werkzeug.socket"].settimeout(None)
        body = self._app(environ, start_response)
        if environ.get(UPGRADED):
            raise ConnectionAbortedError
        return body


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
