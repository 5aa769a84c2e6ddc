"""The head of a request: those of browsers are accepted, all others refused with a status."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.web.head import HeadRefused, parse


def head(first: str, *lines: str) -> bytes:
    return "\r\n".join([first, *lines]).encode("latin-1")


def test_what_browsers_send_is_understood() -> None:
    found = parse(
        head(
            "GET /static/a%20b.js?lang=en&x HTTP/1.1",
            "Host: 127.0.0.1:8080",
            "COOKIE:  a=b; c=d \t",
            "Accept: */*",
            'If-None-Match: "abc"',
        )
    )
    assert (found.method, found.path, found.query) == ("GET", "/static/a b.js", "lang=en&x")
    assert found.headers == {
        "host": "127.0.0.1:8080",
        "cookie": "a=b; c=d",
        "if-none-match": '"abc"',
    }
    assert found.length == 0


@pytest.mark.parametrize(
    ("first", "lines", "status"),
    [
        ("GET /", (), 400),
        ("GET / HTTP/2.0", (), 400),
        ("GET  / HTTP/1.1", (), 400),
        ("get / HTTP/1.1", (), 405),
        ("PUT / HTTP/1.1", (), 405),
        ("GET http://evil.example/ HTTP/1.1", (), 400),
        ("GET * HTTP/1.1", (), 400),
        ("GET /\xe9 HTTP/1.1", (), 400),
        ("GET /%00 HTTP/1.1", (), 400),
        ("GET /%0d%0a HTTP/1.1", (), 400),
        ("GET /" + "x" * 1024 + " HTTP/1.1", (), 414),
        ("GET / HTTP/1.1", ("X",), 400),
        ("GET / HTTP/1.1", (": x",), 400),
        ("GET / HTTP/1.1", ("Host : x",), 400),
        ("GET / HTTP/1.1", ("Host: x", " folded"), 400),
        ("GET / HTTP/1.1", ("Host: x\ny",), 400),
        ("GET / HTTP/1.1", ("Host: x", "host: y"), 400),
        ("GET / HTTP/1.1", ("Origin: " + "x" * 257,), 400),
        ("POST / HTTP/1.1", ("Content-Length: 1", "Content-Length: 2"), 400),
        ("POST / HTTP/1.1", ("Content-Length: +1",), 400),
        ("POST / HTTP/1.1", ("Content-Length: \xb2",), 400),
        ("POST / HTTP/1.1", ("Content-Length: 1025",), 413),
        ("POST / HTTP/1.1", ("Transfer-Encoding: chunked",), 411),
        ("GET / HTTP/1.1", ("X: y",) * 101, 431),
    ],
)
def test_all_else_is_refused_with_its_status(
    first: str, lines: tuple[str, ...], status: int
) -> None:
    with pytest.raises(HeadRefused) as refused:
        parse(head(first, *lines))
    assert refused.value.status.startswith(f"{status} ")
    assert "\n" not in str(refused.value)


@settings(deadline=None, max_examples=400)
@given(st.binary(max_size=300), st.booleans())
def test_any_head_is_a_request_or_a_refusal(text: bytes, begins_well: bool) -> None:
    start = b"GET / HTTP/1.1\r\n" if begins_well else b""
    try:
        found = parse(start + text)
    except HeadRefused:
        return
    assert found.path.startswith("/")
    assert not any(sign in "".join(found.headers.values()) for sign in "\r\n\x00")
