"""The process that sends alerts: several at once, each with a timeout."""

from __future__ import annotations

import contextlib
import json
import os
import resource
import socket
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from gazechair.alerts import apprise_route
from gazechair.alerts.mqtt import Broker
from gazechair.base.child_main import enter_child
from gazechair.base.child_records import RecordWriter

LONGEST = 1 << 16  # bytes of a message to this process
LIMIT_S = 12.0
MOST_AT_ONCE = 16
MOST_ON_ROUTE = 4  # so that a route that hangs does not block the others
MOST_MEMORY = 512 << 20  # bytes; stops a service that answers endlessly
_LOOK_S = 0.1
_ALIVE_S = 1.0

Send = Callable[[str, str, str], str]


class Attempts:
    """Messages being sent, one thread each."""

    def __init__(self, report: Callable[[dict[str, Any]], None], send: Send) -> None:
        self._report = report
        self._send = send
        self._lock = threading.Lock()
        self._open: dict[int, tuple[dict[str, Any], float]] = {}
        self._next = 0
        self._stuck: Counter[str] = Counter()  # threads that did not end in time, by route

    @property
    def stuck(self) -> int:
        """Threads that did not end in time."""
        return self._stuck.total()

    @property
    def worn(self) -> bool:
        """True if so many threads hang that a new process should take over."""
        with self._lock:
            full = max(self._stuck.values(), default=0) >= MOST_ON_ROUTE and not self._open
            return full or self.stuck >= MOST_AT_ONCE

    def begin(self, job: dict[str, Any], now_s: float) -> None:
        """Send `job`; its result or timeout is reported."""
        with self._lock:
            route = str(job["route"])
            on_route = self._stuck[route] + sum(o["route"] == route for o, _ in self._open.values())
            if on_route >= MOST_ON_ROUTE or len(self._open) + self.stuck >= MOST_AT_ONCE:
                self._answer(job, f"{on_route} others are on their way")
                return
            self._next += 1
            number = self._next
            self._open[number] = (job, now_s)
        threading.Thread(target=self._run, args=(number, job), daemon=True).start()

    def look(self, now_s: float) -> None:
        """Report timeouts."""
        with self._lock:
            for number, (job, since_s) in list(self._open.items()):
                if now_s - since_s > LIMIT_S:
                    del self._open[number]
                    self._stuck[str(job["route"])] += 1
                    self._answer(job, f"no answer within {LIMIT_S:g} s")

    def _run(self, number: int, job: dict[str, Any]) -> None:
        problem = self._send(job["url"], job["title"], job["body"])
        with self._lock:
            if self._open.pop(number, None) is None:
                self._stuck[str(job["route"])] -= 1
            else:
                self._answer(job, problem)

    def _answer(self, job: dict[str, Any], problem: str) -> None:
        self._report({"number": job["number"], "route": job["route"], "problem": problem})


def run(fd: int, out: RecordWriter) -> None:
    """Serve until the daemon ends us or too many services hang; then a new process takes over."""

    def report(result: dict[str, Any]) -> None:
        out.facts(json.dumps(result).encode())

    # Its hundred services take a second to load: do that before somebody calls.
    threading.Thread(target=apprise_route.load, name="load", daemon=True).start()
    attempts = Attempts(report, apprise_route.send)
    broker = Broker()
    line = socket.socket(fileno=fd)
    line.settimeout(_LOOK_S)
    alive_s = 0.0
    while not attempts.worn:
        with contextlib.suppress(TimeoutError):
            job = json.loads(line.recv(LONGEST))
            if "mqtt" in job:
                broker.update(job["mqtt"], job["node"], job["state"], time.monotonic())
            elif time.monotonic() < job["till_s"]:
                attempts.begin(job, time.monotonic())
        now_s = time.monotonic()
        attempts.look(now_s)
        broker.tick(now_s)
        if now_s >= alive_s + _ALIVE_S:
            alive_s = now_s
            out.data(broker.problem.encode())


def main() -> None:
    """Entry of `python -m gazechair.alerts.child FD`: jobs arrive over that socket."""
    out = enter_child()
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    with contextlib.suppress(BrokenPipeError):
        run(int(sys.argv[1]), out)
    os._exit(0)  # do not wait for threads that hang


if __name__ == "__main__":
    main()
