"""Turns the host's situation into reasons to call somebody. Pure; times are monotonic seconds."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field

from gazechair.alerts.book import AGAIN_S
from gazechair.alerts.reasons import (
    AT_ONCE_S,
    EXTRA_S,
    HELP_WANTED,
    LOST_S,
    OVERRULED,
    PART,
    REASONS,
    STANDS,
    TRIED,
)

MOVED_S = 2.0  # a chair that moved for this long is not stuck
GAVE_UP_S = 30.0  # after this long without an attempt, the driver does not want to move
EVENT_S = 600.0  # what is raised at once may be over at once: it stays, to be delivered and read
STARTING_S = 60.0  # so long after a restart, a part that is starting may still be what it was
# What keeps failing and works in between lasts: so many seconds of failing each second of working
# takes off. What fails for most of the time for minutes is an alert.
_FORGETS = 1.0
_FORGETS_SHORT = 10.0  # of a reason that is an alert within seconds
_LOOK_S = 1.0  # a longer pause between two looks counts as this much working
_ENDED_BY_OTHERS = {HELP_WANTED, OVERRULED, TRIED}


@dataclass(frozen=True)
class Situation:
    """The host's state at one moment."""

    call: bool = False
    """True while the driver calls for help without an answer."""
    calls: int = 0
    """Calls for help since the host began; there may be several between two looks."""
    coming: bool = False
    """Somebody has answered, and is on the way."""
    press: int = 0
    """The board's number of the newest press: another number is another attempt."""
    wants: bool = False
    """Somebody presses."""
    overruled: bool = False
    """The board allows driving and overrules what was pressed last."""
    moving: bool = False
    problems: Collection[str] = ()
    """Keys of the error handler's."""
    lost: Mapping[str, str] = field(default_factory=dict)
    """Other parts that are lost, and their detail."""
    starting: bool = False
    """Some part has not reported yet whether it works."""


@dataclass(frozen=True)
class Change:
    """A reason begins, or is gone."""

    key: str
    begins: bool
    detail: str = ""
    since_s: float | None = None
    """When the reason began, the last time that it did; None: now."""
    another: bool = False
    """An alert that is open is about another event or part: its answer does not count."""


class Watch:
    """How long each reason has lasted."""

    def __init__(
        self, stuck_s: float, help_wanted: bool = False, named: Collection[str] = ()
    ) -> None:
        """Of before this host began: `help_wanted`: the driver asked for help; `named`: the lost
        parts that an open alert names."""
        self._stuck_s = stuck_s
        self._call = help_wanted
        self._calls = 0
        self._named = named
        self._restored: set[str] = set()
        self._events: set[str] = set()  # open when this host began, and not there then
        self._first_s: float | None = None
        self._looked_s = 0.0
        self._back_s: dict[str, float] = {}  # since when each fails without a break
        self._since_s: dict[str, float] = {}
        self._lost_since_s: dict[str, float] = {}
        self._reported_names = {*named}  # in the newest detail
        self._named_s: dict[str, float] = {}  # when a part that the alert names was last lost
        self._gone_s: dict[str, float] = {}  # kept when the alert is over: it ended later
        self._raised: set[str] = set()
        self._press = 0
        self._stuck_since_s: float | None = None
        self._tried_s = 0.0
        self._moving_since_s: float | None = None

    def look(self, now: Situation, open_keys: Collection[str], now_s: float) -> Iterator[Change]:
        """Yields the changes; `open_keys`: the reasons whose alerts are not over."""
        lasting = {key for key in now.problems if key in REASONS}
        if self._first_s is None:
            self._first_s = now_s
            self._restored = {*open_keys}
            self._events = {key for key in self._restored - lasting if _at_once(key)}
            self._named_s = dict.fromkeys(self._named, now_s)
        if now.call and (not self._call or now.calls != self._calls):
            yield Change(HELP_WANTED, True)
        elif not now.call and not now.coming and HELP_WANTED in open_keys:
            yield Change(HELP_WANTED, False)
        self._call, self._calls = now.call, now.calls
        yield from self._stuck(now, open_keys, now_s)
        failing = (*lasting, *now.lost)
        self._back_s = {key: self._back_s.get(key, now_s) for key in failing}
        self._since_s = self._counted(
            self._since_s, lasting, now_s, lambda key: REASONS[key].lasts_s
        )
        self._raised &= {*lasting, PART} if now.lost else lasting
        for key in sorted(lasting - self._raised):
            if now_s - self._since_s[key] >= REASONS[key].lasts_s:
                self._raised.add(key)
                another = now_s - self._gone_s.get(key, now_s) >= AGAIN_S or key in self._events
                yield Change(key, True, since_s=self._back_s[key], another=another)
        yield from self._parts(now.lost, now_s)
        self._looked_s = now_s
        if not now.starting or now_s - self._first_s >= STARTING_S:
            self._restored = set()
        gone = {*open_keys} - lasting - _ENDED_BY_OTHERS - self._restored
        if now.lost:
            gone.discard(PART)
        self._events -= lasting
        for key in lasting:
            self._gone_s.pop(key, None)
        for key in gone:
            self._gone_s.setdefault(key, now_s)
        for key in sorted(gone):
            stays_s = EVENT_S if _at_once(key) else 0.0
            if now_s - self._gone_s[key] >= stays_s:
                yield Change(key, False)

    def _counted(
        self,
        since_s: Mapping[str, float],
        lasting: Collection[str],
        now_s: float,
        lasts_s: Callable[[str], float],
    ) -> dict[str, float]:
        """When each began, had it lasted without a break; `lasts_s`: of each, until an alert."""
        counted = dict.fromkeys(lasting, now_s)
        for key, began_s in since_s.items():
            if key not in lasting:
                pause_s = now_s - self._looked_s
                forgets = _FORGETS if lasts_s(key) >= LOST_S else _FORGETS_SHORT
                began_s = max(began_s, self._looked_s - lasts_s(key))
                began_s += pause_s + forgets * min(pause_s, _LOOK_S)
            if began_s < now_s:
                counted[key] = began_s
        return counted

    def _parts(self, lost: Mapping[str, str], now_s: float) -> Iterator[Change]:
        since_s = self._lost_since_s = self._counted(
            self._lost_since_s, lost, now_s, lambda _: EXTRA_S
        )
        self._named_s |= dict.fromkeys(self._named_s.keys() & lost.keys(), now_s)
        self._named_s = {
            name: seen_s for name, seen_s in self._named_s.items() if now_s - seen_s < AGAIN_S
        }
        lasted = {name: lost[name] for name in lost if now_s - since_s[name] >= EXTRA_S}
        another = not lasted.keys() <= self._named_s.keys()
        back = PART not in self._raised or not lasted.keys() <= self._reported_names
        if another or (lasted and back):
            self._raised.add(PART)
            self._named_s |= dict.fromkeys(lasted, now_s)
            began_s = min(self._back_s[name] for name in lasted)
            reported = {name: lost[name] for name in lost if name in self._named_s}
            self._reported_names = {*reported}
            yield Change(PART, True, _detail(reported), began_s, another)

    def _stuck(self, now: Situation, open_keys: Collection[str], now_s: float) -> Iterator[Change]:
        stands = STANDS in now.problems  # measured, whatever the board puts out
        if stands or not now.moving:
            self._moving_since_s = None
        elif self._moving_since_s is None:
            self._moving_since_s = now_s
        tried = now.wants or now.press != self._press
        self._press = now.press
        if self._moving_since_s is not None and now_s - self._moving_since_s >= MOVED_S:
            self._stuck_since_s = None
            if OVERRULED in open_keys:
                yield Change(OVERRULED, False)
        elif (now.overruled or stands) and tried:
            self._tried_s = now_s
            if self._stuck_since_s is None:
                self._stuck_since_s = now_s
            if now_s - self._stuck_since_s >= self._stuck_s:
                self._stuck_since_s = now_s  # raise again if it lasts
                yield Change(OVERRULED, True)
        elif now_s - self._tried_s > GAVE_UP_S:
            self._stuck_since_s = None


def _at_once(key: str) -> bool:
    return REASONS[key].lasts_s == AT_ONCE_S


def _detail(lost: Mapping[str, str]) -> str:
    return "; ".join(": ".join(part) for part in sorted(lost.items()))


def named_in(detail: str) -> set[str]:
    """The parts that an alert about lost parts names, from its detail."""
    return {part.partition(": ")[0] for part in detail.split("; ")}
