"""The web server's guard: which Host and Origin pass, how fast, and which files it serves."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gazechair.base.languages import web_folder
from gazechair.base.rate_limit import RateLimit
from gazechair.web import files
from gazechair.web.guard import foreign, is_public, token_in
from gazechair.web.names import own_names

NAMES = frozenset({"localhost", "chair", "chair.local"})


def upgrade(host: str, origin: str | None) -> dict[str, str]:
    environ = {"HTTP_HOST": host, "HTTP_UPGRADE": "websocket"}
    return environ if origin is None else environ | {"HTTP_ORIGIN": origin}


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1", "127.0.0.1:8080", "192.168.1.7:80", "[::1]:8080", "localhost:1", "CHAIR.local"],
)
def test_addresses_and_our_own_names_pass(host: str) -> None:
    assert foreign({"HTTP_HOST": host}, NAMES, "http") is None
    assert foreign(upgrade(host, f"http://{host}"), NAMES, "http") is None


@pytest.mark.parametrize(
    "host", ["", "evil.example", "127.0.0.1.evil.example", "localhost@evil.example", "[::1", "a b"]
)
def test_other_names_do_not(host: str) -> None:
    assert "is not this machine" in str(foreign({"HTTP_HOST": host}, NAMES, "http"))
    assert "is not this machine" in str(foreign(upgrade(host, f"http://{host}"), NAMES, "http"))


def test_a_missing_host_is_refused() -> None:
    assert foreign({}, NAMES, "http") is not None


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "null", "", "http://127.0.0.1", "http://127.0.0.1:81", "file://", "x"],
)
def test_a_socket_of_another_site_is_refused(origin: str) -> None:
    assert "is another site" in str(foreign(upgrade("127.0.0.1:80", origin), NAMES, "http"))


def test_encrypted_pages_come_from_an_encrypted_origin() -> None:
    environ = upgrade("chair:8443", "https://chair:8443")
    assert foreign(environ, NAMES, "https") is None
    assert "is another site" in str(foreign(environ, NAMES, "http"))
    assert "is another site" in str(foreign(upgrade("chair", "http://chair"), NAMES, "https"))


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "http://127.0.0.1:81"])
def test_a_post_of_another_site_is_refused(origin: str) -> None:
    post = {"HTTP_HOST": "127.0.0.1:80", "REQUEST_METHOD": "POST", "HTTP_ORIGIN": origin}
    assert "is another site" in str(foreign(post, NAMES, "http"))
    del post["HTTP_ORIGIN"]
    assert foreign(post, NAMES, "http") is None
    assert foreign({**post, "HTTP_SEC_FETCH_SITE": "same-origin"}, NAMES, "http") is None
    assert "another site" in str(
        foreign({**post, "HTTP_SEC_FETCH_SITE": "cross-site"}, NAMES, "http")
    )


def test_before_pairing_only_the_pairing_page_is_public() -> None:
    for path in ("/pair", "/me", "/static/pair.js", "/static/icon.svg", "/strings/nl.json"):
        assert is_public(path)
    for path in ("/", "/caretaker", "/health", "/static/driver.js", "/pairing", "/ws/control"):
        assert not is_public(path)


def test_all_that_the_pairing_page_loads_is_public() -> None:
    folder = web_folder()
    waiting, loaded = [folder / "pair.html"], set()
    while waiting:
        text = waiting.pop().read_text()
        found = set(re.findall(r'(?:src|href)="/static/([^"]+)"|from "\./([^"]+)"', text))
        names = {one or other for one, other in found} - loaded
        loaded |= names
        waiting += [folder / name for name in names]
    assert {"pair.js", "pair.css", "strings.js"} <= loaded
    assert [name for name in sorted(loaded) if not is_public(f"/static/{name}")] == []


@pytest.mark.parametrize(
    ("cookie", "token"),
    [
        ("gazechair-80=abc", "abc"),
        ("a=b; gazechair-80=abc; c=d", "abc"),
        ("gazechair-81=abc", ""),
        ("", ""),
        (";;=", ""),
        ("gazechair-80", ""),
    ],
)
def test_the_token_is_found_in_the_cookie(cookie: str, token: str) -> None:
    assert token_in({"HTTP_COOKIE": cookie}, "gazechair-80") == token


@settings(deadline=None)
@given(st.text(max_size=60))
def test_any_cookie_is_a_token_or_none(cookie: str) -> None:
    assert isinstance(token_in({"HTTP_COOKIE": cookie}, "gazechair-80"), str)


def test_a_client_that_is_no_browser_sends_no_origin() -> None:
    assert foreign(upgrade("127.0.0.1:80", None), NAMES, "http") is None


@settings(deadline=None)
@given(st.text(max_size=40), st.text(max_size=40))
def test_any_header_gets_an_answer_of_one_line(host: str, origin: str) -> None:
    reason = foreign(upgrade(host, origin), NAMES, "http")
    assert reason is None or "\n" not in reason


def test_own_names_know_the_configured_one() -> None:
    assert {"localhost", "wheels"} <= own_names("Wheels")
    assert "" not in own_names("")


def test_the_rate_limit_lets_a_burst_through_and_refills() -> None:
    limit = RateLimit(per_s=10, burst=5)
    assert [limit.allow(0.0) for _ in range(6)] == [True] * 5 + [False]
    assert [limit.allow(0.1), limit.allow(0.1)] == [True, False]
    assert [limit.allow(99.0) for _ in range(6)] == [True] * 5 + [False]


@settings(deadline=None)
@given(st.lists(st.floats(0, 0.5), max_size=200))
def test_the_rate_limit_holds_over_any_time(pauses_s: list[float]) -> None:
    limit = RateLimit(per_s=100, burst=20)
    now_s = 0.0
    allowed = 0
    for pause_s in pauses_s:
        now_s += pause_s
        allowed += limit.allow(now_s)
    assert allowed <= 20 + 100 * now_s + 1


def test_the_page_s_files_are_found_in_the_checkout() -> None:
    assert (files.web_folder() / "index.html").is_file()
