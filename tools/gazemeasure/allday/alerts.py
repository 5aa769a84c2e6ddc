"""Alerts of the running demo: to the caretaker's page, over two routes, escalating, in a flood."""

from __future__ import annotations

import json
import math
import threading
import time
import urllib.request
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from gazechair.alerts.book import AGAIN_S, MOST_PER_MINUTE
from gazedemo.check import NEUTRAL
from gazedemo.stack import Stack
from gazemeasure.page.raw_page import RawDriver
from gazemeasure.report import Report, percentile
from gazemeasure.stalls import StallProbe

_PAGE_S = 1.0
_ROUTES_S = 5.0
_AFTER_S = 5
_LATE_S = 1.0
_WIPERS_MS = 50.0
_LIMIT_S = 30.0
_A_SECOND = 10
# Nobody has 192.0.2.1: stands for an internet service without internet.
_CONFIG = """
[[alerts.route]]
name = "anna"
url = "json://127.0.0.1:{port}/anna"
[[alerts.route]]
name = "bert"
url = "json://127.0.0.1:{port}/bert"
[[alerts.route]]
name = "internet"
url = "json://192.0.2.1/hush"
[[alerts.route]]
name = "carla"
url = "json://127.0.0.1:{port}/carla"
after_s = {after_s}
"""


class Target:
    """A server that receives the routes' messages; use as a context."""

    def __init__(self) -> None:
        self.received: list[tuple[str, float]] = []
        """(route, monotonic s)."""
        received = self.received

        class Handler(BaseHTTPRequestHandler):
            def do_POST(self) -> None:
                received.append((self.path.strip("/"), time.monotonic()))
                self.rfile.read(int(self.headers["Content-Length"]))
                self.send_response(200)
                self.end_headers()

            def log_message(self, *_: object) -> None:
                pass

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.port = self._server.server_port
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)

    def __enter__(self) -> Target:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._server.shutdown()
        self._server.server_close()

    def on_both(self) -> bool:
        """True if the first two routes have delivered."""
        return max(self.first_s("anna"), self.first_s("bert")) < float("inf")

    def escalated(self) -> bool:
        """True if the third route has delivered."""
        return self.first_s("carla") < float("inf")

    def first_s(self, route: str) -> float:
        """When that route first delivered, monotonic s; inf: not yet."""
        return next((at_s for name, at_s in self.received if name == route), float("inf"))


class _Call:
    """A driver who calls, and a caretaker with an open page."""

    def __init__(self, stack: Stack, driver: RawDriver, caretaker: RawDriver, cookie: str) -> None:
        self._url = stack.url
        self._driver = driver
        self._caretaker = caretaker
        self._cookie = cookie

    def call(self, on: bool = True) -> float:
        """Press *Hulp*; returns the time of the press."""
        now_s = time.monotonic()
        self._driver.send({"k": "call", "on": on})
        return now_s

    def driver_there(self) -> bool:
        """True if the driver's page is connected."""
        return bool(self._driver.state)

    def seen(self) -> bool:
        """True if the caretaker's page shows the call, and the alert that it fetches."""
        return bool(self._caretaker.state.get("call")) and any(
            row["state"] == "open" for row in self.alerts()
        )

    def alerts(self, **posted: Any) -> list[dict[str, Any]]:
        """GET /alerts, or POST `posted` to it."""
        headers = {"Cookie": self._cookie, "Content-Type": "application/json"}
        body = json.dumps(posted).encode() if posted else None
        request = urllib.request.Request(self._url + "alerts", body, headers)
        with urllib.request.urlopen(request, timeout=_LIMIT_S) as answer:
            return list(json.load(answer)["alerts"])


def _until(true: Callable[[], bool], limit_s: float = _LIMIT_S) -> float:
    """Wait until it is true; returns the time, or inf: not within the limit."""
    end_s = time.monotonic() + limit_s
    while not true():
        if time.monotonic() > end_s:
            return float("inf")
        time.sleep(0.01)
    return time.monotonic()


def add(report: Report, micropython: str, tries: int, flood_s: float) -> None:
    """Measure `tries` calls, each on a newly started chair, and a flood of calls on the last."""
    page: list[float] = []
    both: list[float] = []
    late: list[float] = []
    for number in range(tries):
        with Target() as target, StallProbe() as probe:
            config = _CONFIG.format(port=target.port, after_s=_AFTER_S)
            with Stack(micropython, "open", more_config=config) as stack:
                port, cookie = stack.port, stack.cookie("caretaker", "phone")
                with (
                    RawDriver(port, stack.cookie("driver", "tablet")) as driver,
                    RawDriver(port, cookie) as caretaker,
                ):
                    call = _Call(stack, driver, caretaker, cookie)
                    _until(call.driver_there)
                    called_s = call.call()
                    page.append(_until(call.seen) - called_s)
                    _until(target.escalated)
                    both.append(max(target.first_s("anna"), target.first_s("bert")) - called_s)
                    late.append(target.first_s("carla") - called_s - _AFTER_S)
                    if number == tries - 1:
                        _flood(report, stack, call, driver, target, probe, flood_s)
    report.add("alerts: on the caretaker's page, worst", max(page), "s", _PAGE_S)
    report.add("  both routes have delivered, worst", max(both), "s", _ROUTES_S)
    report.add(
        f"  unanswered for {_AFTER_S} s: the next route late by, worst", max(late), "s", _LATE_S
    )
    report.add("  early", max(0.0, -min(late)), "s", 0)
    report.note("alerts: the routes end in a server on this machine; one more leads to where no")
    report.note("network is.")


def _to_wipers_ms(down_s: float, entries: list[list[Any]], probe: StallProbe) -> list[float]:
    """The time until the wipers followed the press, ms; inf: never; none if the machine stalled."""
    moved = (one[1] for one in entries if one[1] >= down_s and (one[2], one[3]) != NEUTRAL)
    at_s = next(moved, math.inf)
    return [] if probe.stalled(down_s, min(at_s, time.monotonic())) else [1000 * (at_s - down_s)]


def _flood(
    report: Report,
    stack: Stack,
    call: _Call,
    driver: RawDriver,
    target: Target,
    probe: StallProbe,
    lasts_s: float,
) -> None:
    """Ten calls per second while the driver drives."""
    (row,) = call.alerts()
    call.alerts(acknowledge=row["number"])
    target.received.clear()
    sim = stack.control()
    to_wipers: list[float] = []
    calls = presses = 0
    began_s = time.monotonic()
    while time.monotonic() < began_s + lasts_s:
        driver.arm()
        sim.do("teleport", x_m=0, y_m=0, heading_deg=0)
        mark = sim.do("wiper_log", since=0)["last"]
        down_s = driver.press()
        for step in range(2 * 3):
            call.call(step % 2 == 0)
            calls += step % 2 == 0
            time.sleep(0.5 / _A_SECOND)
        driver.release()
        for step in range(2 * 3):
            call.call(step % 2 == 0)
            calls += step % 2 == 0
            time.sleep(0.5 / _A_SECOND)
        presses += 1
        to_wipers += _to_wipers_ms(down_s, sim.do("wiper_log", since=mark)["entries"], probe)
    called_s = call.call()
    seen_s = _until(call.seen) - called_s
    # A route that has just been used is used again after a while only.
    late_s = AGAIN_S + _ROUTES_S
    _until(target.on_both, began_s + late_s - time.monotonic())
    both_s = max(target.first_s("anna"), target.first_s("bert")) - began_s
    most = max(sum(one[0] == name for one in target.received) for name in ("anna", "bert"))
    report.add(f"ten calls a second for {lasts_s:g} s: calls", calls, "")
    worst_ms = max(to_wipers, default=math.nan)
    report.add("  press -> wipers meanwhile, worst", worst_ms, "ms", _WIPERS_MS)
    report.add("  press -> wipers, median", percentile(to_wipers, 0.5), "ms")
    report.add("    measured without a stall", 100.0 * len(to_wipers) / presses, "%")
    report.add("  both routes have delivered", both_s, "s", late_s)
    report.add("  messages over one route", most, "", MOST_PER_MINUTE)
    report.add("  alerts in the diary", len(call.alerts()), "", 2)
    report.add("  the last one on the page after", seen_s, "s", _PAGE_S)
