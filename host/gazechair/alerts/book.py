"""The book of alerts: merges repeats, uses route after route until somebody answers. Pure.

Times `now_s` are monotonic seconds, `wall_s` seconds since 1970 for people to read.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from gazechair.alerts.reasons import HELP, KINDS, REASONS, TEST

OPEN, ACKNOWLEDGED, OVER = STATES = ("open", "acknowledged", "over")
WAITING, TRYING, SENT, FAILED = DELIVERY_STATES = ("waiting", "trying", "sent", "failed")

_RESTARTED = "the host was restarted before it was sent"
MOST_ALERTS = 100  # kept, the oldest go first
MOST_PER_MINUTE = 10  # deliveries over one route, attempts included
FOR_HELP = 3  # of them are reserved for the driver's call
AGAIN_S = 60.0  # back within this it is the same alert; also the shortest interval on a route
ANSWER_S = 20.0  # an attempt without a result by then has failed
RETRIES_S = (10.0, 20.0, 40.0, 60.0)  # the last one repeats
_MINUTE_S = 60.0
_NEVER_S = float("-inf")
_MOST_AT = 1e11


@dataclass(frozen=True)
class Route:
    """One service that reaches somebody."""

    name: str
    after_s: float = 0.0
    """How long an alert has been open without an answer before this route is used."""
    kinds: tuple[str, ...] = KINDS


@dataclass
class Delivery:
    """An alert on one route."""

    due_s: float
    state: str = WAITING
    detail: str = ""
    """Why the newest attempt failed."""
    attempts: int = 0
    tried_s: float = _NEVER_S


@dataclass
class Alert:
    """One alert, with all its repetitions."""

    number: int
    key: str
    """Of reasons.REASONS and of the string tables."""
    at: float
    """Wall time."""
    sentence: str = ""
    """The driver's own."""
    detail: str = ""
    count: int = 1
    state: str = OPEN
    by: str = ""
    """Who has acknowledged it."""
    since: float = 0.0
    """Wall time since which there is no answer: its routes wait from then."""
    answered: float = 0.0
    """Wall time of the newest acknowledgement."""
    ended_s: float = _NEVER_S
    deliveries: dict[str, Delivery] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """One of KINDS."""
        return REASONS[self.key].kind

    def as_json(self) -> dict[str, Any]:
        """For the diary and the page."""
        return {
            "number": self.number,
            "key": self.key,
            "kind": self.kind,
            "at": _bounded(self.at),
            "since": _bounded(self.since),
            "answered": _bounded(self.answered),
            "sentence": self.sentence,
            "detail": self.detail,
            "count": self.count,
            "state": self.state,
            "by": self.by,
            "deliveries": {
                name: {"state": one.state, "detail": one.detail}
                for name, one in self.deliveries.items()
            },
        }


class Book:
    """Not thread-safe: the owner locks."""

    def __init__(self, routes: Iterable[Route]) -> None:
        self._routes = {route.name: route for route in routes}
        self._used: dict[str, deque[float]] = {name: deque() for name in self._routes}
        self._alerts: list[Alert] = []
        self._next = 1
        self.revision = 0
        """Changes with everything that as_json() shows."""

    # Results

    def as_json(self) -> list[dict[str, Any]]:
        """Every alert, oldest first."""
        return [alert.as_json() for alert in self._alerts]

    def alerts(self) -> tuple[Alert, ...]:
        """Every alert, oldest first."""
        return tuple(self._alerts)

    def of(self, key: str) -> Alert | None:
        """The newest alert for this reason."""
        return next((alert for alert in reversed(self._alerts) if alert.key == key), None)

    def find(self, number: int) -> Alert | None:
        """The alert of that number."""
        return next((alert for alert in self._alerts if alert.number == number), None)

    def open_keys(self) -> set[str]:
        """Reasons whose alert is not over."""
        return {alert.key for alert in self._alerts if alert.state != OVER}

    def due(self, now_s: float) -> list[tuple[Alert, Route]]:
        """Messages to send now; each counts as in progress until `result`."""
        for alert, name, one in self._all():
            if one.state == TRYING and now_s - one.tried_s > ANSWER_S:
                self.result(alert.number, name, "no result of the attempt", now_s)
        waiting = [
            (alert, name, one)
            for alert, name, one in self._all()
            if one.state in (WAITING, FAILED) and now_s >= one.due_s and _live(alert, one)
        ]
        waiting.sort(key=lambda item: (item[2].attempts > 0, KINDS.index(item[0].kind)))
        found = []
        for alert, name, one in waiting:
            if self._allowed(name, alert.kind, now_s):
                one.state, one.tried_s = TRYING, now_s
                one.attempts += 1
                self.revision += 1
                found.append((alert, self._routes[name]))
        return found

    # Events

    def raise_(
        self,
        key: str,
        now_s: float,
        wall_s: float,
        sentence: str = "",
        detail: str = "",
        since_s: float | None = None,
        another: bool = False,
    ) -> Alert:
        """Raise an alert for a reason, perhaps again. Raises KeyError for an unknown reason.

        `since_s`: when the reason began, None: now; `another`: see Change.
        """
        alert = self.of(key)
        began_s = now_s if since_s is None else since_s
        if alert is None or (alert.state == OVER and began_s - alert.ended_s >= AGAIN_S):
            return self._new(key, now_s, wall_s, sentence, detail)
        alert.count += 1
        self.revision += 1
        if alert.kind == TEST:
            for one in alert.deliveries.values():
                if one.state == FAILED:
                    one.state, one.attempts, one.due_s = WAITING, 0, now_s
            return alert
        alert.sentence, alert.detail = sentence, detail
        # A person who asks again wants an answer again; a part that fails again is known.
        if another or (alert.kind == HELP and alert.state != OPEN):
            self._open_again(alert, now_s, wall_s)
        elif alert.state == OVER:
            alert.state, alert.ended_s = ACKNOWLEDGED if alert.by else OPEN, _NEVER_S
        return alert

    def end(self, key: str, now_s: float) -> None:
        """The reason is gone."""
        alert = self.of(key)
        if alert is not None and alert.state != OVER:
            alert.state, alert.ended_s = OVER, now_s
            self.revision += 1

    def acknowledge(self, number: int, by: str, wall_s: float) -> bool:
        """Somebody takes over; False: there is no such alert, or nothing to acknowledge."""
        alert = self.find(number)
        if alert is None or alert.state == OVER or (alert.by and alert.state == ACKNOWLEDGED):
            return False
        if alert.state == OPEN:
            alert.answered = wall_s
        alert.state, alert.by = ACKNOWLEDGED, by
        self.revision += 1
        return True

    def result(self, number: int, route: str, problem: str, now_s: float) -> None:
        """An attempt has ended; `problem`: why it failed, "" when it was delivered."""
        alert = self.find(number)
        one = None if alert is None else alert.deliveries.get(route)
        if one is None or one.state != TRYING:
            return
        one.state, one.detail = (FAILED, problem) if problem else (SENT, "")
        one.due_s = now_s + RETRIES_S[min(one.attempts, len(RETRIES_S)) - 1]
        self.revision += 1

    def messenger_lost(self, now_s: float) -> None:
        """Attempts in progress may have been lost: retry them, the first time at once."""
        for alert, name, one in self._all():
            if one.state == TRYING:
                self.result(alert.number, name, "its sender had to be started again", now_s)
                if one.attempts == 1 and alert.kind != TEST:
                    one.due_s = now_s

    def restore(self, rows: Iterable[Mapping[str, Any]], now_s: float, wall_s: float) -> None:
        """Continue from as_json() of an earlier host: open alerts stay open, others stay over.

        Rows that are not alerts are skipped. Raises nothing.
        """
        for row in rows:
            alert = alert_of(row)
            if alert is None or alert.number < self._next:
                continue
            self._next = alert.number + 1
            if alert.state == OVER or alert.kind == TEST:
                alert.deliveries = _results(alert.kind, row["deliveries"], now_s)
            else:
                self._continue(alert, row["deliveries"], now_s, wall_s)
            self._keep(alert)

    # Inside

    def _new(self, key: str, now_s: float, wall_s: float, sentence: str, detail: str) -> Alert:
        alert = Alert(self._next, key, wall_s, sentence, detail, since=wall_s)
        self._next += 1
        for route in self._routes.values():
            if alert.kind == TEST:
                alert.deliveries[route.name] = Delivery(now_s)
            elif alert.kind in route.kinds:
                alert.deliveries[route.name] = Delivery(now_s + route.after_s)
        self._keep(alert)
        return alert

    def _continue(
        self, alert: Alert, before: Mapping[str, Any], now_s: float, wall_s: float
    ) -> None:
        alert.since = min(alert.since, wall_s)  # the clock was ahead: it counts from now on
        for route in self._routes.values():
            if alert.kind not in route.kinds:
                continue
            waited_s = min(max(0.0, wall_s - alert.since), route.after_s)
            old = before.get(route.name, {})
            one = Delivery(now_s + route.after_s - waited_s)
            if old.get("state") in (SENT, FAILED):
                one.state, one.detail = old["state"], str(old.get("detail", ""))
            alert.deliveries[route.name] = one

    def _open_again(self, alert: Alert, now_s: float, wall_s: float) -> None:
        # A call is acknowledged first and gets the name later; one that is over keeps the name.
        answered = alert.state == ACKNOWLEDGED or alert.by != ""
        alert.at = wall_s
        if answered:
            alert.since = wall_s
        alert.state, alert.by, alert.ended_s = OPEN, "", _NEVER_S
        for name, one in alert.deliveries.items():
            due_s = now_s + self._routes[name].after_s
            if one.state == SENT or (one.state == WAITING and answered):
                one.state, one.attempts = WAITING, 0
                one.due_s = max(due_s, one.tried_s + AGAIN_S)
            elif one.state == FAILED and answered:
                one.due_s = max(due_s, one.due_s)  # it reached no one: retried as before

    def _keep(self, alert: Alert) -> None:
        self._alerts.append(alert)
        self.revision += 1
        if len(self._alerts) > MOST_ALERTS:
            # Open alerts are kept: there are at most as many as reasons.
            oldest = next((one for one in self._alerts if one.state == OVER), self._alerts[0])
            self._alerts.remove(oldest)

    def _all(self) -> Iterator[tuple[Alert, str, Delivery]]:
        for alert in self._alerts:
            for name, one in alert.deliveries.items():
                yield alert, name, one

    def _allowed(self, route: str, kind: str, now_s: float) -> bool:
        used = self._used[route]
        while used and now_s - used[0] >= _MINUTE_S:
            used.popleft()
        if len(used) >= MOST_PER_MINUTE - (0 if kind == HELP else FOR_HELP):
            return False
        used.append(now_s)
        return True


def _bounded(wall_s: float) -> int:
    return round(min(max(0.0, wall_s), _MOST_AT))


def _live(alert: Alert, one: Delivery) -> bool:
    # A test is attempted once, whatever becomes of it.
    return one.attempts == 0 if alert.kind == TEST else alert.state == OPEN


def _results(kind: str, before: Mapping[str, Any], now_s: float) -> dict[str, Delivery]:
    # Nothing of it is sent any more: its routes need not exist.
    found = {}
    for name, one in before.items():
        state, detail = one.get("state"), str(one.get("detail", ""))
        if kind == TEST and state in (WAITING, TRYING):
            state, detail = FAILED, _RESTARTED
        if state in DELIVERY_STATES:
            found[name] = Delivery(now_s, state, detail, attempts=1)
    return found


def alert_of(row: Mapping[str, Any]) -> Alert | None:
    """The alert in a line of the diary, without its deliveries; None: not an alert."""
    try:
        alert = Alert(
            int(row["number"]),
            str(row["key"]),
            float(row["at"]),
            str(row["sentence"]),
            str(row["detail"]),
            int(row["count"]),
            str(row["state"]),
            str(row["by"]),
            float(row.get("since", row["at"])),
            float(row.get("answered", 0.0)),
        )
        good = alert.key in REASONS and alert.state in STATES and 0 <= alert.at <= _MOST_AT
        good = good and all(isinstance(one, dict) for one in row["deliveries"].values())
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError):
        return None
    return alert if good else None
