"""Requests that a stranger may send, as raw bytes, each intended to be expensive."""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator

PUBLIC = (
    "/pair",
    "/me",
    "/authority.crt",
    "/static/pair.js",
    "/static/pair.css",
    "/static/icon.svg",
    "/static/strings.js",
    "/strings/nl.json",
    "/strings/none.json",
)
PRIVATE = (
    "/",
    "/caretaker",
    "/health",
    "/static/driver.js",
    "/pairing",
    "/pairing/code",
    "/pairing/revoke",
    "/profiles",
    "/settings",
    "/ws/control",
    "/ws/video",
    "/nothing",
)
ROUTES = PUBLIC + PRIVATE
_KEY = base64.b64encode(bytes(16)).decode()
UPGRADE = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    f"Sec-WebSocket-Key: {_KEY}\r\n"
)
BIG = 15_000  # just below the limit of a request


def request(path: str, headers: str = "", body: bytes = b"", method: str = "GET") -> bytes:
    """A request to this machine."""
    length = f"Content-Length: {len(body)}\r\n" if body else ""
    head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\n{length}{headers}\r\n"
    return head.encode("latin-1") + body


def cookies(name: str) -> Iterator[tuple[str, str]]:
    """Cookie headers; `name` is the pairing cookie's."""
    yield "cookie of backslashes", f'Cookie: {name}="' + "\\" * BIG + '"'
    yield "cookie of octal escapes", f'Cookie: {name}="' + "\\101" * (BIG // 4) + '"'
    yield "cookie of semicolons", "Cookie: " + ";" * BIG
    yield "cookie of pairs", "Cookie: " + "a=b; " * (BIG // 5)
    yield "cookie of its own name", "Cookie: " + f"{name}=x;" * (BIG // (len(name) + 3))
    yield "cookie of almost tokens", "Cookie: " + (f"{name}=" + "A" * 43 + "!;") * (BIG // 70)
    yield "cookie of made-up tokens", "Cookie: " + (f"{name}=" + "A" * 43 + ";") * (BIG // 70)
    yield "cookie of spaces", "Cookie: " + f"{name}=" + " " * BIG + "x"
    yield "cookie of quotes", "Cookie: " + '"' * BIG
    yield "cookie of commas", "Cookie: " + "$Path=,=" * (BIG // 8)
    yield "cookie beyond ASCII", "Cookie: " + f"{name}=" + "\xe9" * BIG


def headers() -> Iterator[tuple[str, str]]:
    """One header, or many."""
    for each in ("Accept", "Accept-Language", "Accept-Encoding", "Cache-Control", "X"):
        yield f"{each} of commas", f"{each}: " + "a;q=0.1," * (BIG // 8)
    yield "Range of ranges", "Range: bytes=" + "0-1," * (BIG // 4)
    yield "If-None-Match of quotes", "If-None-Match: " + '"' * BIG
    yield "If-None-Match of tags", "If-None-Match: " + 'W/"a",' * (BIG // 6)
    yield "If-Match of commas", "If-Match: " + "," * BIG
    yield "If-Modified-Since of digits", "If-Modified-Since: " + "1 " * (BIG // 2)
    yield "If-Range of spaces", "If-Range: " + " " * BIG + "x"
    yield "Content-Type of parameters", "Content-Type: application/json" + ";a=b" * (BIG // 4)
    yield "Content-Type of quotes", 'Content-Type: a/b;a="' + "\\" * BIG
    yield "Content-Length of digits", "Content-Length: " + "9" * BIG
    yield "Content-Length twice", "Content-Length: 0\r\nContent-Length: 5"
    yield "Content-Length below 0", "Content-Length: -5"
    yield "Content-Length unreadable", "Content-Length: \xb2"
    yield "Transfer-Encoding of commas", "Transfer-Encoding: " + "chunked," * (BIG // 8)
    yield "Transfer-Encoding chunked", "Transfer-Encoding: chunked"
    yield "Origin of brackets", "Origin: http://" + "[" * BIG
    yield "Origin of at signs", "Origin: http://" + "@" * BIG
    yield "Host twice", "Host: evil.example"
    yield "Upgrade of commas", "Upgrade: " + "websocket," * (BIG // 10)
    yield "Connection of commas", "Connection: " + "Upgrade," * (BIG // 8)
    yield "extensions", UPGRADE + "Sec-WebSocket-Extensions: " + "x;a=b," * (BIG // 6)
    yield "subprotocols", UPGRADE + "Sec-WebSocket-Protocol: " + "x," * (BIG // 2)
    yield "extension of quotes", UPGRADE + 'Sec-WebSocket-Extensions: x;a="' + "\\" * BIG
    yield "a websocket", UPGRADE.rstrip()
    yield "a websocket's bad key", UPGRADE.replace(_KEY, "?" * BIG).rstrip()
    yield "a websocket of version 0", UPGRADE.replace(": 13", ": 0").rstrip()
    yield "Authorization", "Authorization: Digest " + 'a="b",' * (BIG // 6)
    yield "Forwarded", "X-Forwarded-For: " + "1.1.1.1," * (BIG // 8)
    yield "Expect", "Expect: 100-continue"
    yield "90 headers", "\r\n".join(f"X-{k}: {'v' * 150}" for k in range(90))
    yield "4000 headers", "\r\n".join(["X: y"] * (BIG // 6))
    yield "the same header", "\r\n".join(["Accept: " + "y" * 140] * 95)
    yield "folded headers", "X: y" + "\r\n y" * (BIG // 4)
    yield "a header without a colon", "x" * BIG
    yield "a header's name of spaces", " " * BIG + ": x"
    yield "control characters", "X: " + "\x00\x01\x7f" * (BIG // 3)
    yield "line ends alone", "X: y" + "\n" * BIG
    yield "carriage returns", "X: y" + "\r" * BIG


def targets(path: str) -> Iterator[tuple[str, str]]:
    """Request targets on a route."""
    yield "query of ampersands", path + "?" + "&" * BIG
    yield "query of pairs", path + "?" + "a=b&" * (BIG // 4)
    yield "query of percents", path + "?" + "%" * BIG
    yield "query of escapes", path + "?" + "%0d%0a" * (BIG // 6)
    yield "short query of escapes", path + "?%0d%0aSet-Cookie:x=y"
    yield "path of slashes", path + "/" * BIG
    yield "path of dots", path + "/.." * (BIG // 3)
    yield "short path of dots", path + "/.." * 50
    yield "path of escapes", path + "%2e%2e%2f" * (BIG // 9)
    yield "short path of escapes", path + "%2e%2e%2f" * 50
    yield "path with a zero", path + "%00"
    yield "path beyond Unicode", path + "%ff%fe%ed%a0%80"
    yield "path of a long name", path + "/" + "x" * 600
    yield "another authority", "http://evil.example" + path
    yield "an authority of brackets", "//[[[" + path
    yield "a fragment", path + "#" * 500


def bodies() -> Iterator[tuple[str, str, bytes]]:
    """POST requests: name, headers, body."""
    json_type = "Content-Type: application/json\r\n"
    yield "body of brackets", json_type, b"[" * 1000
    yield "body of objects", json_type, b'{"a":' * 200
    yield "body of digits", json_type, b"1" * 1000
    yield "body of a huge number", json_type, b'{"code":1e' + b"9" * 900 + b"}"
    yield "body of escapes", json_type, b'"' + b"\\ud800" * 160 + b'"'
    yield "code of a half character", json_type, b'{"code":"\\ud800"}'
    yield "name of a half character", json_type, b'{"code":"2222-2222","name":"\\ud800"}'
    yield "code of zeros", json_type, b'{"code":"\\u0000"}'
    yield "body of keys", json_type, b"{" + b",".join(b'"%d":0' % k for k in range(120)) + b"}"
    yield "body beyond UTF-8", json_type, b"\xff" * 500
    yield "body of UTF-16", json_type, '{"code":"x"}'.encode("utf-16")
    yield "body of nothing", json_type, b" "
    yield "a wrong code", json_type, json.dumps({"code": "2222-2222"}).encode()
    yield "a form", "Content-Type: application/x-www-form-urlencoded\r\n", b"a=b&" * 250
    many = b"--x\r\nContent-Disposition: form-data; name=a\r\n\r\n\r\n"
    yield "parts", "Content-Type: multipart/form-data; boundary=x\r\n", many * 20
    yield "too much", json_type, b"[" * 5000
    charset = "Content-Type: application/json; charset=zlib\r\n"
    yield "body of another charset", charset, b"x" * 100


def whole(cookie_name: str) -> Iterator[tuple[str, bytes]]:
    """Every route with every header, cookie, target and body; names are for people."""
    for path in ROUTES:
        yield f"{path}", request(path)
        for name, header in [*cookies(cookie_name), *headers()]:
            yield f"{path}: {name}", request(path, header + "\r\n")
        for name, target in targets(path):
            yield f"{path}: {name}", request(target)
        for name, header, body in bodies():
            yield f"{path}: {name}", request(path, header, body, "POST")
        for method in ("HEAD", "PUT", "OPTIONS", "TRACE", "x" * 1000, "GET\x00", ""):
            yield f"{path}: method {method[:8]}", request(path, method=method)
    yield "no request", b"\r\n" * 5000
    yield "no version", b"GET /pair\r\n\r\n"
    yield "another version", b"GET /pair HTTP/9.9\r\nHost: 127.0.0.1\r\n\r\n"
    yield "no host", b"GET /pair HTTP/1.1\r\n\r\n"
    for name in ("[" * 250, "1" * 250, "a." * 125, "127.0.0.1:" + "9" * 200, "%" * 250):
        yield f"host {name[:4]}", f"GET /pair HTTP/1.1\r\nHost: {name}\r\n\r\n".encode()
    yield "endless line", b"G" * 20_000
    yield "binary", bytes(range(256)) * 60
