"""Alerts in the daemon: watches the host, keeps the book, has messages sent."""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from gazechair.alerts import apprise_route, mqtt
from gazechair.alerts.book import ACKNOWLEDGED, OPEN, OVER, SENT, Alert, Book, Route
from gazechair.alerts.diary import Diary
from gazechair.alerts.message import message_of
from gazechair.alerts.reasons import HELP, HELP_WANTED, KINDS, PART, TEST, TRIED
from gazechair.alerts.sender import LOST, Sender
from gazechair.alerts.watch import Situation, Watch, named_in
from gazechair.base import health as states
from gazechair.base.battery import charge_percent
from gazechair.base.health import HealthRegistry
from gazechair.base.languages import sentence
from gazechair.base.reasons import ALERT_DIARY
from gazechair.base.throttled_log import ThrottledLog
from gazechair.config.settings import Config

log = logging.getLogger(__name__)
throttled = ThrottledLog(log)

LOOK_S = 0.2
_KEEP_S = 1.0
_UPDATE_S = 5.0


class Chair(Protocol):
    """What alerts need from Control."""

    def situation(self) -> Situation: ...
    def answer_call(self) -> None: ...
    def person(self) -> Mapping[str, Any]: ...


class Alerts:
    """Thread-safe; nothing here waits for a disk or a network. No lock is held in a callback."""

    def __init__(
        self,
        config: Config,
        folder: Path,
        parts: HealthRegistry,
        clock: Callable[[], float] = time.monotonic,
        wall: Callable[[], float] = time.time,
        battery: Callable[[], int | None] = charge_percent,
    ) -> None:
        """`folder`: the state folder; `battery`: its charge in percent."""
        self._battery = battery
        self._language = config.web.language
        self._urls = {route.name: route.url for route in config.routes}
        self._helpers = [route.name for route in config.routes if HELP in route.kinds]
        self._clock = clock
        self._wall = wall
        self._lock = threading.Lock()
        self._diary = Diary(folder, parts.part(ALERT_DIARY))
        routes = [Route(one.name, one.after_s, one.kinds) for one in config.routes]
        self._book = Book(routes)
        self._before = secrets.randbelow(1 << 30)  # a page that knew an earlier host reloads
        self._book.restore(self._diary.read(), clock(), wall())
        self.help_wanted = False
        """True if the driver called for help before this host began, without an answer."""
        self.answered_s: float | None = None
        """When somebody answered the driver's call before this host began, on `clock`."""
        self._watch = self._restored(config.alerts.stuck_s)
        self._failing: set[str] = set()
        self._missing = False  # Apprise, as far as is known
        self._broker = config.alerts.mqtt
        self._node = mqtt.node()
        self._published: dict[str, str] = {}
        self._published_s = 0.0
        self._charge: int | None = None
        wanted = config.routes or self._broker
        self._health = parts.part("alerts") if wanted else None
        self._sender = (
            Sender(self._health, self.result, self._sender_lost) if self._health else None
        )
        self._chair: Chair | None = None
        self._kept = self._book.revision
        self._ended = threading.Event()
        self._threads = [
            threading.Thread(target=self._run, name="alerts", daemon=True),
            threading.Thread(target=self._keep, name="alert-diary", daemon=True),
        ]

    def _restored(self, stuck_s: float) -> Watch:
        """What to watch, after what the diary holds of the time before this host began."""
        call, lost = self._book.of(HELP_WANTED), self._book.of(PART)
        self.help_wanted = call is not None and call.state == OPEN
        if call is not None and call.state == ACKNOWLEDGED:
            self.answered_s = self._clock() - max(0.0, self._wall() - call.answered)
        named = named_in(lost.detail) if lost is not None and lost.state != OVER else ()
        return Watch(stuck_s, self.help_wanted, named)

    def watch(self, chair: Chair) -> None:
        """Watch `chair`, from `start` on."""
        self._chair = chair

    def start(self) -> None:
        """Start watching and sending."""
        self._missing = not apprise_route.installed()
        if self._health is not None and self._missing and not self._broker:
            self._health.set(states.LOST, LOST, apprise_route.MISSING)
        elif self._sender is not None:
            self._sender.start()
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """End the process and the threads; the diary is on disk afterwards."""
        self._ended.set()
        for thread in self._threads:
            if thread.is_alive():
                thread.join(5.0)
        if self._sender is not None:
            self._sender.stop()

    # For pages

    @property
    def revision(self) -> int:
        """Changes with every alert."""
        return self._before + self._book.revision

    def reaches_somebody(self) -> bool:
        """True if a call has reached somebody outside the page, or presumably would."""
        with self._lock:
            call = self._book.of(HELP_WANTED)
            if call is not None and call.state == OPEN:
                return any(one.state == SENT for one in call.deliveries.values())
            if self._missing or (self._health is not None and self._health.state == states.LOST):
                return False
            return any(name not in self._failing for name in self._helpers)

    def as_json(self) -> dict[str, Any]:
        """GET /alerts."""
        with self._lock:
            return {
                "revision": self.revision,
                "routes": list(self._urls),
                "alerts": self._book.as_json(),
            }

    def acknowledge(self, number: int, by: str) -> bool:
        """`by` takes over; False: no open alert has that number."""
        with self._lock:
            done = self._book.acknowledge(number, by, self._wall())
            alert = self._book.find(number)
        if done and alert is not None and alert.kind == HELP and self._chair is not None:
            self._chair.answer_call()
        return done

    def test(self, by: str) -> None:
        """Send a test over every route."""
        with self._lock:
            alert = self._book.raise_(TRIED, self._clock(), self._wall(), detail=by)
            self._book.acknowledge(alert.number, by, self._wall())
            self._book.end(TRIED, self._clock())  # it is sent anyway

    # Inside

    def result(self, number: int, route: str, problem: str) -> None:
        """An attempt has ended; see Book.result."""
        with self._lock:
            self._book.result(number, route, problem, self._clock())
            if problem:
                self._failing.add(route)
            else:
                self._failing.discard(route)

    def _sender_lost(self) -> None:
        with self._lock:
            self._book.messenger_lost(self._clock())

    def look(self) -> None:
        """Look for changes; called every LOOK_S."""
        assert self._chair is not None
        situation = self._chair.situation()
        person = self._chair.person()
        now_s = self._clock()
        if self._broker and now_s - self._published_s >= _UPDATE_S:
            self._charge = self._battery()
        with self._lock:
            for change in self._watch.look(situation, self._book.open_keys(), now_s):
                if change.begins:
                    self._book.raise_(
                        change.key,
                        now_s,
                        self._wall(),
                        str(person["help_sentence"]),
                        change.detail,
                        change.since_s,
                        change.another,
                    )
                else:
                    self._book.end(change.key, now_s)
            call = self._book.of(HELP_WANTED)
            if call is not None and call.state == OPEN and situation.coming:
                # The page sends the name in a moment.
                self._book.acknowledge(call.number, "", self._wall())
            due = self._book.due(now_s)
            state = self._as_state()
        self._update_broker(state, now_s)
        for alert, route in due:
            problem = self._send(alert, route.name, str(person["name"]))
            if problem:
                self.result(alert.number, route.name, problem)

    def _update_broker(self, state: dict[str, str], now_s: float) -> None:
        news = state != self._published or now_s - self._published_s >= _UPDATE_S
        if self._sender is not None and self._broker and news:
            self._published, self._published_s = state, now_s
            self._sender.update_broker(self._broker, self._node, state)

    def _as_state(self) -> dict[str, str]:
        """The state that Home Assistant shows."""
        rows = [alert for alert in self._book.alerts() if alert.kind != TEST]
        kinds = {alert.kind for alert in rows if alert.state == OPEN}
        last = sentence(self._language, rows[-1].key) if rows else ""
        charge = {} if self._charge is None else {mqtt.BATTERY: str(self._charge)}
        return {
            "help": "ON" if HELP in kinds else "OFF",
            "state": next((kind for kind in KINDS if kind in kinds), mqtt.OK),
            "last_alert": last,
            **charge,
        }

    def _send(self, alert: Alert, route: str, driver: str) -> str:
        if self._sender is None or not apprise_route.installed():
            return apprise_route.MISSING
        message = message_of(alert, driver, self._language)
        return self._sender.send(alert.number, route, self._urls[route], message)

    def _run(self) -> None:
        while not self._ended.wait(LOOK_S):
            try:
                self.look()
            except Exception:  # whatever is wrong, the next alert must go out
                throttled.warn("alerts: error in a look", exc_info=True)

    def _keep(self) -> None:
        # A disk may hang: callers do not wait for it.
        ended = False
        while not ended:
            ended = self._ended.wait(_KEEP_S)
            self.keep()

    def keep(self) -> None:
        """Write the diary if it has changed; called every _KEEP_S."""
        with self._lock:
            revision = self._book.revision
            rows = self._book.as_json() if revision != self._kept else None
        if rows is not None and self._diary.write(rows):
            self._kept = revision
