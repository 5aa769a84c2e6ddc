"""A strict parser for the head of an HTTP request, linear in its length.

It accepts only what browsers send (RFC 9112): an origin-form target, lines that end in CR LF, no
folded header. The application sees only the headers listed here, so that no library ever parses an
arbitrary header from a stranger.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from urllib.parse import unquote_to_bytes

from gazechair.sensing.mapping.stored.packed_map import MOST_BYTES

MOST_HEAD_BYTES = 16_384
MOST_BODY_BYTES = 1_024
_FILES = {"/maps/import": MOST_BYTES}  # by path: a larger body, from caretakers only; see Guard
_MOST_TARGET = 1_024
_MOST_VALUE = 256
_MOST_LINES = 100
_METHODS = ("GET", "HEAD", "POST")
_VERSIONS = ("HTTP/1.1", "HTTP/1.0")
_TARGET = re.compile(r"/[!-~]*")
_NAME = re.compile(r"[!#$%&'*+.^_`|~0-9A-Za-z-]+")
_CONTROL = re.compile(r"[\x00-\x08\x0a-\x1f\x7f]")
_LENGTH = re.compile(r"[0-9]{1,9}")
# Dropped when longer than _MOST_VALUE, as no browser's is: the answer only gets larger.
_MAY_BE_LEFT_OUT = ("if-none-match", "accept-encoding")
_USED = {
    "host",
    "origin",
    "cookie",
    "content-type",
    "content-length",
    "upgrade",
    "connection",
    "sec-websocket-key",
    "sec-websocket-version",
    "sec-fetch-site",
    *_MAY_BE_LEFT_OUT,
}


class HeadRefused(Exception):
    """Raised for a request that this server refuses: the status, and one plain line."""

    def __init__(self, status: str, line: str) -> None:
        super().__init__(line)
        self.status = status


@dataclass(frozen=True)
class Head:
    """A request without its body."""

    method: str
    path: str
    """Percent-decoded, bytes as characters (latin-1), as WSGI requires."""
    query: str
    version: str
    headers: dict[str, str]
    """Lower-case names; only those that are used here."""
    length: int
    """Length of the body, bytes."""


def parse(text: bytes) -> Head:
    """The head in `text`, which ends with the last header's line. Raises HeadRefused."""
    first, *lines = text.decode("latin-1").split("\r\n")
    if len(lines) > _MOST_LINES:
        raise HeadRefused("431 Request Header Fields Too Large", f"at most {_MOST_LINES} headers")
    method, path, query, version = _first_line(first)
    headers: dict[str, str] = {}
    for line in lines:
        name, colon, value = line.partition(":")
        if not colon or not _NAME.fullmatch(name):
            raise HeadRefused("400 Bad Request", "a header has no name")
        name = name.lower()
        if name == "transfer-encoding":
            raise HeadRefused("411 Length Required", "send a body with its Content-Length")
        if name not in _USED:
            continue
        value = value.strip(" \t")
        if name in headers:
            raise HeadRefused("400 Bad Request", f"{name} was sent twice")
        if _CONTROL.search(value):
            raise HeadRefused("400 Bad Request", f"{name} holds a control character")
        if len(value) > _MOST_VALUE and name != "cookie":
            if name in _MAY_BE_LEFT_OUT:
                continue
            raise HeadRefused("400 Bad Request", f"{name} has more than {_MOST_VALUE} characters")
        headers[name] = value
    most_bytes = _FILES.get(path, MOST_BODY_BYTES) if method == "POST" else MOST_BODY_BYTES
    return Head(method, path, query, version, headers, _length(headers, most_bytes))


def _first_line(line: str) -> tuple[str, str, str, str]:
    words = line.split(" ")
    if len(words) != 3 or words[2] not in _VERSIONS:
        raise HeadRefused("400 Bad Request", "no request of HTTP 1.1")
    method, target, version = words
    if method not in _METHODS:
        raise HeadRefused("405 Method Not Allowed", f"use one of {', '.join(_METHODS)}")
    if len(target) > _MOST_TARGET:
        raise HeadRefused("414 URI Too Long", f"an address has at most {_MOST_TARGET} characters")
    if not _TARGET.fullmatch(target):
        raise HeadRefused("400 Bad Request", "an address begins with / and is plain ASCII")
    path, _, query = target.partition("?")
    path = unquote_to_bytes(path).decode("latin-1")
    if _CONTROL.search(path) or "\t" in path:
        raise HeadRefused("400 Bad Request", "an address holds a control character")
    return method, path, query, version


def _length(headers: dict[str, str], most_bytes: int) -> int:
    text = headers.get("content-length", "0")
    if not _LENGTH.fullmatch(text):
        raise HeadRefused("400 Bad Request", "Content-Length is no number")
    if int(text) > most_bytes:
        raise HeadRefused("413 Content Too Large", f"a body has at most {most_bytes} bytes")
    return int(text)
