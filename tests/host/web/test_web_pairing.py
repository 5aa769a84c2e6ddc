"""Before pairing nothing is usable; a code gives a cookie; each role its own page; revocation."""

from __future__ import annotations

import json
import time
from typing import Any

import pytest
import simple_websocket

from gazechair.people.pairing.store import MOST_DEVICES

# Unpaired


def test_an_unpaired_browser_sees_the_pairing_page_and_nothing_else(visitor: Any) -> None:
    nobody = visitor(None)
    for path in ("/", "/caretaker"):
        status, headers, _ = nobody.get(path)
        assert (status, headers["Location"]) == (303, "/pair")
    assert nobody.get("/?lang=en")[1]["Location"] == "/pair?lang=en"
    for path in ("/pair", "/static/pair.js", "/static/pair.css", "/strings/nl.json"):
        assert nobody.get(path)[0] == 200
    for path in ("/health", "/static/driver.js", "/pairing", "/settings", "/nothing"):
        status, headers, raw = nobody.get(path)
        assert status == 401
        assert json.loads(raw)["reason"] == "not_paired"
        assert "default-src 'none'" in headers["Content-Security-Policy"]
        assert headers["Cache-Control"] == "no-store"
    assert nobody.get("/me")[0] == 401
    assert nobody.post("/pairing/code", {"role": "driver"})[0] == 401


@pytest.mark.parametrize("path", ["/ws/control", "/ws/video"])
@pytest.mark.parametrize("cookie", ["", "gazechair-{}=", "gazechair-{}=" + "A" * 43, "x=y"])
def test_an_unpaired_socket_is_refused(
    port: Any, server: Any, visitor: Any, path: str, cookie: str
) -> None:
    with pytest.raises(simple_websocket.ConnectionError):
        visitor(None).open(path, Cookie=cookie.format(server.port))
    assert port.clients == 0


# Pairing


def test_a_code_makes_a_cookie_that_scripts_cannot_read(
    server: Any, desk: Any, visitor: Any
) -> None:
    nobody = visitor(None)
    code = desk.new_code("caretaker").text
    status, headers, answer = nobody.post("/pair", {"code": code, "name": "phone"})
    assert (status, answer) == (200, {"role": "caretaker"})
    cookie, *attributes = headers["Set-Cookie"].split("; ")
    assert cookie.startswith(f"gazechair-{server.port}=")
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} <= set(attributes)
    assert "Secure" not in attributes  # not encrypted on this machine
    nobody.headers = {"Cookie": cookie}
    me = json.loads(nobody.get("/me")[2])
    assert (me["role"], me["name"]) == ("caretaker", "phone")
    assert nobody.open().next()["k"] == "welcome"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ([], "send a JSON object"),
        ({}, '"code" must be a text'),
        ({"code": 5}, '"code" must be a text'),
        ({"code": ""}, '"code" must be a text'),
        ({"code": "x" * 41}, '"code" must be a text'),
        ({"code": "ABCD-EFGH", "name": None}, '"name" must be a text'),
    ],
)
def test_nonsense_pairs_nobody(visitor: Any, content: object, words: str) -> None:
    status, _, answer = visitor(None).post("/pair", content)
    assert (status, answer["reason"]) == (400, "bad_message")
    assert words in answer["detail"]


def test_only_json_pairs(visitor: Any, desk: Any) -> None:
    code = desk.new_code("driver").text
    status, _, answer = visitor(None).post(
        "/pair", {"code": code}, **{"Content-Type": "text/plain"}
    )
    assert (status, answer["reason"]) == (400, "bad_message")
    assert desk.is_open(code)


def test_a_body_that_is_too_long_is_refused(visitor: Any) -> None:
    status, _, answer = visitor(None).post("/pair", {"code": "x" * 2000})
    assert status in (400, 413)
    assert answer["reason"] == "bad_message"


def test_another_site_pairs_nobody(visitor: Any, desk: Any) -> None:
    code = desk.new_code("driver").text
    for origin in ("http://evil.example", "null"):
        status, _, answer = visitor(None).post("/pair", {"code": code}, Origin=origin)
        assert (status, answer["reason"]) == (403, "not_allowed")
    assert desk.is_open(code)


def test_guessing_is_slowed_while_the_driver_drives_on(
    port: Any, driver: Any, visitor: Any
) -> None:
    page = driver.open()
    page.next_of("state")
    guesser = visitor(None)
    answers = [guesser.post("/pair", {"code": f"3222-222{k}"}) for k in range(2, 10)]
    assert [status for status, _, _ in answers] == [403] * 5 + [429] * 3
    assert answers[0][2]["reason"] == "wrong_code"
    assert answers[-1][2]["reason"] == "too_many_guesses"
    assert answers[-1][2]["wait_s"] == 1
    assert int(answers[-1][1]["Retry-After"]) == answers[-1][2]["wait_s"]
    # The same address, paired: nothing is limited.
    assert driver.get("/")[0] == 200
    assert driver.open().next()["k"] == "welcome"
    page.send({"k": "stop"})
    port.wait_for(lambda: "stop" in port.kinds())


def test_a_page_that_is_opened_keeps_its_pairing(driver: Any, visitor: Any) -> None:
    assert driver.headers["Cookie"] in driver.get("/")[1]["Set-Cookie"]
    assert "Max-Age=34560000" in driver.get("/")[1]["Set-Cookie"]
    assert "Set-Cookie" not in driver.get("/static/driver.js")[1]
    assert "Set-Cookie" not in visitor(None).get("/")[1]


# Roles


@pytest.mark.parametrize(
    ("role", "path", "status", "where"),
    [
        ("driver", "/", 200, None),
        ("driver", "/caretaker", 303, "/"),
        ("caretaker", "/", 303, "/caretaker"),
        ("caretaker", "/caretaker", 200, None),
        ("viewer", "/", 303, "/caretaker"),
        ("viewer", "/caretaker", 200, None),
    ],
)
def test_each_role_has_its_page(
    visitor: Any, role: str, path: str, status: int, where: str | None
) -> None:
    found, headers, _ = visitor(role).get(path)
    assert (found, headers.get("Location")) == (status, where)


@pytest.mark.parametrize("role", ["driver", "caretaker", "viewer"])
def test_a_socket_has_the_role_of_its_device(port: Any, visitor: Any, role: str) -> None:
    visitor(role).open().next_of("state")
    assert port.roles == [role]


@pytest.mark.parametrize("role", ["driver", "viewer"])
def test_only_a_caretaker_pairs_and_revokes(visitor: Any, role: str) -> None:
    device = visitor(role)
    assert device.get("/pairing")[0] == 403
    assert device.post("/pairing/code", {"role": "caretaker"})[0] == 403
    assert device.post("/pairing/revoke", {"id": device.id})[2]["reason"] == "not_allowed"
    assert device.post("/pairing/code", {"role": "king"})[0] == 403
    assert device.post("/pairing/revoke", {})[0] == 403
    assert device.get("/me")[0] == 200


def test_a_caretaker_lists_pairs_and_revokes(visitor: Any, desk: Any) -> None:
    caretaker, driver = visitor("caretaker"), visitor("driver")
    rows = json.loads(caretaker.get("/pairing")[2])["devices"]
    assert [(row["id"], row["role"], row["you"]) for row in rows] == [
        (caretaker.id, "caretaker", True),
        (driver.id, "driver", False),
    ]
    assert "digest" not in rows[0]
    assert abs(rows[0]["created"] - time.time()) < 3600
    status, _, made = caretaker.post("/pairing/code", {"role": "viewer"})
    assert (status, made["role"], made["valid_s"]) == (200, "viewer", 600.0)
    assert made["url"].endswith("/pair")
    assert desk.is_open(made["code"])
    assert len(made["qr"]) == len(made["qr"][0])
    assert caretaker.post("/pairing/code", {"role": "king"})[2]["reason"] == "bad_message"
    status, _, left = caretaker.post("/pairing/revoke", {"id": driver.id})
    assert [row["id"] for row in left["devices"]] == [caretaker.id]
    assert driver.get("/me")[0] == 401


def test_a_full_list_is_said(visitor: Any, desk: Any) -> None:
    caretaker = visitor("caretaker")
    for _ in range(MOST_DEVICES - 1):
        desk._store.add("viewer", "x", 1)
    code = desk.new_code("driver").text
    status, _, answer = visitor(None).post("/pair", {"code": code})
    assert status == 507
    assert "revoke one first" in answer["detail"]
    assert caretaker.get("/me")[0] == 200


# Revocation


def test_a_revoked_device_is_sent_away_at_once(
    port: Any, desk: Any, visitor: Any, video: Any
) -> None:
    tablet, other = visitor("driver"), visitor("driver")
    control, picture = tablet.open(), tablet.open("/ws/video")
    control.next_of("state")  # its number is 1
    neighbour = other.open()
    neighbour.next_of("state")
    desk.revoke(tablet.id)
    assert port.gone == [1]  # before revoke returned: what it commanded has stopped
    assert control.until_closed() == (4001, "this device is not paired any more")
    picture.until_closed()
    neighbour.next_of("state")
    for path in ("/ws/control", "/ws/video"):
        with pytest.raises(simple_websocket.ConnectionError):
            tablet.open(path)  # the token replayed
    assert tablet.get("/static/driver.js")[0] == 401


def test_a_revoked_device_that_floods_is_cut_too(port: Any, desk: Any, visitor: Any) -> None:
    tablet = visitor("driver")
    page = tablet.open()
    page.next_of("state")
    for _ in range(50):
        page.send({"k": "cmd", "verb": "forward"})
    desk.revoke(tablet.id)
    assert page.until_closed()[0] == 4001
