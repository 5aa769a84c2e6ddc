"""Alerts under attack: bad services and brokers, bad state files, wrong clocks, races of people."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from controlrig import FakeLink
from fulldisk import full
from gazechair.alerts import child
from gazechair.alerts.book import (
    ANSWER_S,
    FOR_HELP,
    MOST_PER_MINUTE,
    SENT,
    Book,
    Route,
)
from gazechair.alerts.child import MOST_ON_ROUTE, Attempts
from gazechair.alerts.diary import FILE_NAME, Diary
from gazechair.alerts.mqtt import Broker
from gazechair.alerts.reasons import HELP, HELP_WANTED, REASONS
from gazechair.alerts.service import Alerts
from gazechair.base.health import HealthRegistry
from gazechair.config.rules import Secret
from gazechair.config.settings import Config, RouteConfig
from gazechair.driving.control import Control
from patience import PATIENCE_S, wait_until

FAILURES = [key for key, reason in REASONS.items() if reason.kind == "failure"]


# People


class House:
    """Control and alerts, stepped by the test."""

    def __init__(self, folder: Path, wall_s: float = 1e9) -> None:
        self.now_s = 10.0
        self.wall_s = wall_s
        config = Config(routes=(RouteConfig("zus", Secret("json://localhost")),))
        parts = HealthRegistry(lambda: self.now_s)
        for name in ("board", "lidar", "camera"):
            parts.part(name).set("ok")
        self.alerts = Alerts(config, folder, parts, lambda: self.now_s, lambda: self.wall_s)
        self.control = Control(
            config, FakeLink(), parts, clock=lambda: self.now_s, alerts=self.alerts
        )
        self.alerts.watch(self.control)
        assert self.alerts._sender is not None
        self.alerts._sender.send = lambda *_: ""  # type: ignore[method-assign]
        self.page = self.control.connect("driver")

    def help(self, on: bool = True) -> None:
        self.control.receive(self.page, {"k": "call", "on": on})

    def look(self, seconds: float = 0.2) -> None:
        self.now_s += seconds
        self.wall_s += seconds
        self.alerts.look()

    def rows(self) -> list[tuple[str, str]]:
        return [(row["state"], row["by"]) for row in self.alerts.as_json()["alerts"]]


def test_a_driver_who_asks_again_before_the_next_look_is_heard_again(tmp_path: Path) -> None:
    """Answered and requested again between two looks, which see nothing of it."""
    house = House(tmp_path)
    house.help()
    house.look()
    assert house.alerts.acknowledge(1, "Anna")
    house.help()
    house.look()
    assert house.rows() == [("open", "")]


def test_help_pressed_twice_in_one_slice_is_one_alert(tmp_path: Path) -> None:
    house = House(tmp_path)
    for on in (True, False, True):
        house.help(on)
    house.look()
    assert house.rows() == [("open", "")]
    house.look()
    assert house.alerts.as_json()["alerts"][0]["count"] == 1


def test_of_two_who_acknowledge_at_once_one_is_named(tmp_path: Path) -> None:
    house = House(tmp_path)
    house.help()
    house.look()
    start = threading.Barrier(8, timeout=PATIENCE_S)
    won: list[str] = []

    def answer(name: str) -> None:
        start.wait()
        if house.alerts.acknowledge(1, name):
            won.append(name)

    threads = [threading.Thread(target=answer, args=(f"p{n}",)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert house.rows() == [("acknowledged", won[0])]
    assert len(won) == 1


def test_acknowledged_while_it_escalates_nobody_else_is_called() -> None:
    book = Book([Route("zus"), Route("sms", 60.0)])
    alert = book.raise_(HELP_WANTED, 0.0, 0.0)
    assert [route.name for _, route in book.due(0.0)] == ["zus"]
    book.result(1, "zus", "", 1.0)
    assert [route.name for _, route in book.due(60.0)] == ["sms"]  # it is in progress
    assert book.acknowledge(1, "Anna", 0.0)
    book.result(1, "sms", "no network", 61.0)
    assert not [book.due(float(now_s)) for now_s in range(61, 400) if book.due(float(now_s))]
    assert alert.by == "Anna"


def test_help_does_not_wait_behind_a_storm_of_failures() -> None:
    book = Book([Route("zus")])
    for key in FAILURES:
        book.raise_(key, 0.0, 0.0)
    sent = [alert.kind for alert, _ in book.due(0.0)]
    assert len(sent) == MOST_PER_MINUTE - FOR_HELP
    book.raise_(HELP_WANTED, 1.0, 1.0)
    assert [alert.kind for alert, _ in book.due(1.0)] == [HELP]


def test_what_a_killed_messenger_had_is_sent_again_at_once_but_not_for_ever() -> None:
    book = Book([Route("zus")])
    book.raise_(HELP_WANTED, 0.0, 0.0)
    tried = []
    for now_s in range(int(3 * ANSWER_S)):
        if book.due(float(now_s)):
            tried.append(now_s)
            book.messenger_lost(float(now_s))
    assert tried[:3] == [0, 1, 21]
    book.due(61.0)
    book.result(1, "zus", "", 62.0)
    book.messenger_lost(62.0)
    assert book.alerts()[0].deliveries["zus"].state == SENT


# State


@pytest.mark.parametrize(
    "damage", ["erased", "0xff", "folder", "read-only folder", "folder and another one"]
)
def test_a_diary_that_is_damaged_is_replaced_and_somebody_is_called(
    tmp_path: Path, damage: str
) -> None:
    file = tmp_path / FILE_NAME
    Diary(tmp_path).write([{"key": "x"}])
    if damage == "0xff":
        file.write_bytes(b"\xff" * 5000)
    else:
        file.unlink()
    if "folder" in damage:
        file.mkdir(0o500 if "read-only" in damage else 0o700)
        (tmp_path / "alerts.damaged").touch()
    if "another" in damage:
        (tmp_path / "alerts.damaged1").mkdir()
    house = House(tmp_path)
    house.help()
    house.look()
    house.alerts.keep()
    assert House(tmp_path).rows() == [("open", "")]
    if damage == "0xff":
        assert (tmp_path / "alerts.damaged").read_bytes() == b"\xff" * 5000


def test_a_disk_that_is_full_while_an_alert_is_written_delays_nothing_but_the_diary(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    house = House(tmp_path)

    with monkeypatch.context() as patch:
        patch.setattr("gazechair.base.state_folder.os.fsync", full)
        house.help()
        house.look()
        house.alerts.keep()
        assert house.rows() == [("open", "")]
        assert Diary(tmp_path).read() == []
    house.alerts.keep()
    assert len(Diary(tmp_path).read()) == 1


@pytest.mark.parametrize("years", [-60, -5, 5, 1000])
def test_a_clock_that_jumps_by_years_neither_loses_nor_delays_an_alert(
    tmp_path: Path, years: int
) -> None:
    house = House(tmp_path, wall_s=1.8e9)
    house.help()
    house.look()
    house.wall_s += years * 31_557_600.0
    house.look()
    house.alerts.acknowledge(1, "Anna")
    house.help()
    house.look()
    house.alerts.keep()
    again = House(tmp_path, wall_s=1.8e9)
    assert again.rows() == [("open", "")]
    again.look()
    assert again.alerts.as_json()["alerts"][0]["deliveries"]["zus"]["state"] != "waiting"


@pytest.mark.parametrize("wall_s", [-1e8, 0.0, 1e12])
def test_an_alert_of_a_clock_that_was_never_set_outlives_the_host(
    tmp_path: Path, wall_s: float
) -> None:
    house = House(tmp_path, wall_s)
    house.help()
    house.look()
    house.alerts.keep()
    assert House(tmp_path).rows() == [("open", "")]


# Services


def answers(line: socket.socket, how: str, port: int) -> None:
    """One connection of a bad service."""
    line.settimeout(PATIENCE_S)
    line.recv(65536)
    with contextlib.suppress(OSError):
        if how == "garbage":
            line.sendall(os.urandom(2000))
        elif how == "redirects":
            place = f"Location: http://127.0.0.1:{port}/x\r\nContent-Length: 0\r\n\r\n"
            line.sendall(f"HTTP/1.1 307 Gone\r\n{place}".encode())
        else:
            line.sendall(b"HTTP/1.1 200 OK\r\n\r\n")
            while True:
                line.sendall(b"x" * (1 << 20))
    line.close()


@pytest.fixture
def bad() -> Iterator[Callable[[str], str]]:
    """Starts a bad service; its address."""
    servers: list[socket.socket] = []

    def serve(how: str) -> str:
        server = socket.create_server(("127.0.0.1", 0))
        servers.append(server)
        port = server.getsockname()[1]

        def run() -> None:
            with contextlib.suppress(OSError):
                while True:
                    line, _ = server.accept()
                    threading.Thread(target=answers, args=(line, how, port), daemon=True).start()

        threading.Thread(target=run, daemon=True).start()
        return f"json://127.0.0.1:{port}/hush-hush"

    yield serve
    for server in servers:
        server.close()


SEND = """
import resource, sys
from gazechair.alerts import apprise_route
apprise_route.load()
resource.setrlimit(resource.RLIMIT_DATA, (120 << 20, 120 << 20))
print([apprise_route.send(url, "a", "b") for url in sys.argv[1:]])
"""


def test_services_that_flood_answer_garbage_or_redirect_for_ever_are_failures(
    bad: Callable[[str], str],
) -> None:
    """Without a bound the flood fills the memory of the chair's computer."""
    urls = [bad("garbage"), bad("redirects"), bad("floods")]
    found = subprocess.run(
        [sys.executable, "-c", SEND, *urls],
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(p for p in sys.path if p)),
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
    )
    problems = eval(found.stdout)  # printed by our own process
    assert len(problems) == 3
    assert all(problems)
    assert "hush" not in found.stdout


def test_the_process_bounds_its_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    limits: list[Any] = []
    monkeypatch.setattr(child, "enter_child", lambda: None)
    monkeypatch.setattr(child, "run", lambda *_: None)
    monkeypatch.setattr(child.resource, "setrlimit", lambda *limit: limits.append(limit))
    monkeypatch.setattr(child.os, "_exit", lambda _: None)
    monkeypatch.setattr(sys, "argv", ["child", "3"])
    child.main()
    assert limits == [(child.resource.RLIMIT_DATA, (child.MOST_MEMORY,) * 2)]


def test_a_route_that_hangs_leaves_the_others_room_and_is_ended_by_a_new_process() -> None:
    gate = threading.Event()
    reported: list[dict[str, Any]] = []

    def send(url: str, *_: str) -> str:
        if url == "hangs":
            gate.wait(PATIENCE_S)
        return ""

    attempts = Attempts(reported.append, send)
    for number in range(30):
        job = {"number": number, "route": "sms", "url": "hangs", "title": "", "body": ""}
        attempts.begin(job, 0.0)
    assert len(reported) == 30 - MOST_ON_ROUTE
    reported.clear()
    attempts.begin({"number": 99, "route": "zus", "url": "x", "title": "", "body": ""}, 0.0)
    wait_until(lambda: reported)
    assert reported == [{"number": 99, "route": "zus", "problem": ""}]
    assert not attempts.worn
    attempts.look(100.0)
    assert attempts.worn
    gate.set()
    wait_until(lambda: attempts.stuck == 0)
    assert not attempts.worn


def test_a_broker_that_accepts_and_never_answers_holds_up_nobody() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        broker = Broker()
        url = f"mqtt://127.0.0.1:{server.getsockname()[1]}"
        began_s = time.monotonic()
        for now_s in range(600):
            broker.update(url, "x", {"help": "ON" if now_s % 2 else "OFF"}, now_s)
            broker.tick(now_s)
        assert time.monotonic() - began_s < PATIENCE_S / 2
        assert broker.problem == "not connected yet"
        broker._client.loop_stop()


def test_an_alert_with_an_endless_detail_is_sent() -> None:
    from gazechair.alerts.book import Alert
    from gazechair.alerts.message import message_of

    message = message_of(Alert(1, "alert_part", 0.0, detail="x" * 200_000), "Kees", "nl")
    assert len(json.dumps(message.body)) < 2000
