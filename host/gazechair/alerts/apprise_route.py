"""Sends one message over one Apprise service; reports failures without the secrets."""

from __future__ import annotations

import logging
import re
import threading
from importlib.util import find_spec
from urllib.parse import unquote

MISSING = "nothing can be sent: pip install 'gazechair[alerts]'"
_MOST = 200  # characters of a reason
_SHORT = 4  # characters: shorter parts of an address are not secret


def installed() -> bool:
    """True if Apprise is installed."""
    return find_spec("apprise") is not None


def load() -> None:
    """Load every service now instead of with the first message."""
    if installed():
        import apprise

        apprise.Apprise.instantiate("json://localhost")


def send(url: str, title: str, body: str) -> str:
    """Send it; returns why that failed, in one line, "" when delivered. May take very long."""
    if not installed():
        return MISSING
    import apprise

    logger = logging.getLogger("apprise")
    logger.propagate = False  # its lines may contain secrets
    collector = _LogLines()
    logger.addHandler(collector)
    try:
        service = apprise.Apprise.instantiate(url)
        if service is None:
            return "this is no address that Apprise knows"
        if service.notify(title=title, body=body, notify_type=apprise.NotifyType.WARNING):
            return ""
    except Exception as error:  # code of a hundred services
        collector.lines.append(repr(error))
    finally:
        logger.removeHandler(collector)
    reason = " ".join(" ".join(collector.lines).split())
    return _without_secrets(reason, url)[:_MOST] or "the service refused it"


class _LogLines(logging.Handler):
    """Collects the warnings that this thread causes."""

    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._thread = threading.get_ident()
        self.lines: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        if record.thread == self._thread:
            self.lines.append(record.getMessage())


def _without_secrets(text: str, url: str) -> str:
    parts = re.split(r"[:/@?&=,]+", url.partition("://")[2])
    parts = sorted({*parts, *map(unquote, parts)}, key=len, reverse=True)
    for part in parts:
        if len(part) >= _SHORT:
            text = text.replace(part, "...")
    return text
