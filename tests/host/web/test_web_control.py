"""The control socket: receives messages, sends states, refuses everything malformed in words."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from typing import Any

import pytest
import simple_websocket
from wsproto.events import Ping

from gazechair.web import control_sockets, page_client
from gazechair.web.page_client import PageClient
from gazechair.web.processor_share import BURST_S, LONGEST_WAIT_S, SHARE

LONG_S = 20.0


def test_a_page_is_welcomed_and_then_hears_states(open_page: Any) -> None:
    page = open_page()
    welcome = page.next()
    assert (welcome["k"], welcome["name"], welcome["insecure"]) == ("welcome", "a driver", False)
    assert page.next() == {"k": "state", "token": 7, "level": "ok"}
    assert page.next() == {"k": "token", "token": 7}
    page.next_of("state")


def test_a_change_is_told(port: Any, open_page: Any) -> None:
    page = open_page()
    page.next_of("state")
    port.set_level("error")
    while page.next_of("state")["level"] != "error":
        pass


def test_a_welcome_that_changed_is_sent_again_before_the_state(port: Any, open_page: Any) -> None:
    """The board may come, with its limits, after the page."""
    page = open_page()
    assert page.next_of("welcome")["command_ttl_ms"] is None
    page.next_of("state")
    port.ttl_ms = 300
    port.set_level("error")
    again = page.next_of("welcome")
    assert (again["command_ttl_ms"], again["name"]) == (300, "a driver")
    assert page.next()["k"] == "state"


def test_messages_reach_the_driver_port_with_their_client(port: Any, open_page: Any) -> None:
    first, second = open_page(), open_page()
    first.next_of("welcome")
    client = second.next_of("welcome")["client"]
    second.send({"k": "stop"})
    port.wait_for(lambda: (client, {"k": "stop"}) in port.received)


def test_a_refusal_goes_back_to_its_page(open_page: Any) -> None:
    page = open_page()
    page.send({"k": "cmd", "verb": "forward"})
    assert page.next_of("refused")["reason"] == "stale_token"


@pytest.mark.parametrize(
    "bad",
    [
        b"\x00\x01",
        "",
        "forward",
        "{",
        "[]",
        "5",
        "null",
        '{"k":5}',
        "{}",
        '{"k":"cmd","token":NaN}',
        '{"k":"cmd","token":Infinity}',
        "[" * 200,
        '{"k":"' + "x" * 300 + '"}',
        '{"k":"\u20ac' + "\u20ac" * 90 + '"}',
    ],
)
def test_a_malformed_message_is_refused_and_the_socket_lives(
    port: Any, bad: str | bytes, open_page: Any
) -> None:
    page = open_page()
    page.send(bad)
    answer = page.next_of("refused")
    assert (answer["what"], answer["reason"]) == ("message", "bad_message")
    assert "\n" not in answer["detail"]
    page.send({"k": "hb", "token": 1})
    port.wait_for(lambda: port.kinds() == ["hb"])


def test_an_oversized_message_closes_the_socket(port: Any, open_page: Any) -> None:
    page = open_page()
    page.send("x" * 1_100)
    code, _ = page.until_closed()
    # Too big; or without a code, when the server's reset of the connection overtakes its close
    # frame.
    assert code in (1009, 1005)
    port.wait_for(lambda: port.gone == [1])
    assert port.received == []


def test_what_comes_too_fast_is_refused_but_never_a_stop(port: Any, open_page: Any) -> None:
    page = open_page()
    for _ in range(180):
        page.send({"k": "hb", "token": 1})
    for _ in range(20):
        page.send({"k": "stop"})
    assert page.next_of("refused")["reason"] == "too_fast"
    port.wait_for(lambda: port.kinds().count("stop") == 20)


def test_a_flood_ends_the_connection(port: Any, open_page: Any) -> None:
    page = open_page()
    with contextlib.suppress(OSError, simple_websocket.ConnectionClosed):
        for _ in range(100_000):
            page.send({"k": "hb", "token": 1})
    port.wait_for(lambda: port.gone == [1])


def test_a_closed_socket_disconnects_its_client(port: Any, open_page: Any) -> None:
    page = open_page()
    page.next()
    page.ws.close()
    port.wait_for(lambda: port.gone == [1])


def test_a_cut_connection_disconnects_its_client(port: Any, open_page: Any) -> None:
    page = open_page()
    page.next()
    page.ws.sock.shutdown(socket.SHUT_RDWR)
    port.wait_for(lambda: port.gone == [1])


def test_a_role_has_its_places_and_takes_none_of_anothers(port: Any, visitor: Any) -> None:
    for _ in range(control_sockets.PAGES["viewer"]):
        visitor("viewer").open().next_of("state")
    assert visitor("viewer").open().until_closed()[0] == 1013
    assert visitor("driver").open().next()["k"] == "welcome"
    assert visitor("caretaker").open().next()["role"] == "driver"  # what this port says
    assert port.roles == ["viewer"] * control_sockets.PAGES["viewer"] + ["driver", "caretaker"]


def test_a_freed_place_is_given_again(port: Any, visitor: Any) -> None:
    pages = [visitor("viewer").open() for _ in range(control_sockets.PAGES["viewer"])]
    for page in pages:
        page.next_of("state")
    pages[0].ws.close()
    port.wait_for(lambda: port.gone != [])
    deadline_s = time.monotonic() + LONG_S
    while time.monotonic() < deadline_s:
        with contextlib.suppress(simple_websocket.ConnectionClosed):
            if visitor("viewer").open().next()["k"] == "welcome":
                return
    pytest.fail("the freed place was not given again")


def test_a_device_that_comes_back_replaces_its_own_page(port: Any, driver: Any) -> None:
    pages = []
    for _ in range(control_sockets.PAGES["driver"] - 1):
        pages.append(driver.open())
        pages[-1].next_of("state")  # they are numbered as they are served
    assert driver.open().next()["k"] == "welcome"
    port.wait_for(lambda: len(port.gone) == 1)
    assert pages[port.gone[0] - 1].until_closed()[0] == 1013


def test_a_page_sent_away_is_told_why_even_when_its_reader_notices_first(
    port: Any, driver: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Slow:
        """A socket whose farewell takes a while to get out."""

        def __init__(self, ws: Any) -> None:
            self._ws = ws

        def __getattr__(self, name: str) -> Any:
            return getattr(self._ws, name)

        def close(self, code: int, why: str) -> None:
            time.sleep(2 * page_client._LOOK_S)
            self._ws.close(code, why)

    monkeypatch.setattr(control_sockets, "_FALLEN_SILENT_S", 0.0)
    init = PageClient.__init__
    monkeypatch.setattr(PageClient, "__init__", lambda self, ws, *rest: init(self, Slow(ws), *rest))
    lost = driver.open()
    lost.next_of("state")
    driver.open()
    assert lost.until_closed()[0] == 1013


def test_a_page_fallen_silent_makes_way_for_its_own_return(
    port: Any, driver: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(control_sockets, "_FALLEN_SILENT_S", 0.0)
    lost = driver.open()
    lost.next_of("state")
    assert driver.open().next()["k"] == "welcome"
    port.wait_for(lambda: port.gone == [1])
    assert lost.until_closed()[0] == 1013


def test_a_slow_reader_delays_nobody_else(port: Any, open_page: Any) -> None:
    slow = open_page()
    slow.next()
    # It no longer reads, and changes keep its backlog of states growing.
    slow.ws.input_buffer = _Blocking()
    quick = open_page()
    quick.next_of("state")
    for number in range(30):
        quick.send({"k": "hb", "token": number})
        port.set_level(f"level {number}")
        while quick.next_of("state")["level"] != f"level {number}":
            pass
    port.wait_for(lambda: port.kinds().count("hb") == 30)


class _Blocking(list[Any]):
    def append(self, item: Any) -> None:
        threading.Event().wait(60.0)


def test_answers_to_pings_do_not_break_the_states_under_way(port: Any, open_page: Any) -> None:
    page = open_page()
    for number in range(300):
        page.ws.sock.send(page.ws.ws.send(Ping(b"p" * 100)))
        if number % 3 == 0:
            port.set_level(f"level {number}")
    while page.next_of("state")["level"] != "level 297":
        pass


def test_what_a_page_has_cost_keeps_nobody_waiting_when_it_goes(
    port: Any, driver: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not after hours of driving: it is not billed to those who are not known yet."""

    def dear(client: int, message: dict[str, Any]) -> list[dict[str, Any]]:
        end_s = time.thread_time() + 1.1 * (SHARE * LONGEST_WAIT_S + BURST_S)
        while time.thread_time() < end_s:
            pass
        return []

    monkeypatch.setattr(port, "receive", dear)
    page = driver.open()
    page.send({"k": "hb", "token": 1})
    page.next()
    page.ws.close()
    port.wait_for(lambda: port.gone == [1])
    for thread in threading.enumerate():
        if thread.name.startswith("web-request-"):
            thread.join(LONG_S)
    assert driver.get("/me")[0] == 200
