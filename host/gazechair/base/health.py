"""The health of each part: starting, ok, degraded or lost, with a reason key and a line of text."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass

from gazechair.base.languages import advice
from gazechair.base.latest_value import Clock
from gazechair.base.reasons import DEGRADED as DEGRADED
from gazechair.base.reasons import LOST as LOST
from gazechair.base.reasons import STARTING as STARTING
from gazechair.base.reasons import kind

OK = "ok"
STATES = (STARTING, OK, DEGRADED, LOST)

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class HealthState:
    """A part's health at one moment."""

    state: str
    """One of STATES."""
    reason: str
    """A key of the string tables: "ok", "lidar_lost", "wrong_port", ..."""
    detail: str
    """One plain line for a log or the doctor: what, where, what to do. May be empty."""
    since_s: float
    """Monotonic time at which state or reason last changed."""
    about: str = ""
    """The configuration's name of what the reason is about, for a page; may be empty."""


class Health:
    """The health of one part. The part sets it from any thread; anyone reads it."""

    def __init__(
        self,
        name: str,
        clock: Clock = time.monotonic,
        on_change: Callable[[], None] | None = None,
    ) -> None:
        """`on_change` is called without arguments, from the setting thread, after each change."""
        self.name = name
        self._clock = clock
        self._on_change = on_change
        self._lock = threading.Lock()
        self._now = HealthState(STARTING, f"{kind(name)}_starting", "", clock())

    def set(self, state: str, reason: str = "ok", detail: str = "", about: str = "") -> None:
        """Report the part's state; repeating it is free. Raises ValueError on an unknown state."""
        if state not in STATES:
            raise ValueError(f"health state {state!r} is none of {', '.join(STATES)}")
        with self._lock:
            old = self._now
            if (old.state, old.reason, old.detail, old.about) == (state, reason, detail, about):
                return
            same = (old.state, old.reason) == (state, reason)
            since_s = old.since_s if same else self._clock()
            self._now = HealthState(state, reason, detail, since_s, about)
        if not same:
            level = logging.WARNING if state in (DEGRADED, LOST) else logging.INFO
            log.log(level, "%s is %s: %s", self.name, state, detail or reason)
        if self._on_change is not None:
            self._on_change()

    def now(self) -> HealthState:
        """The health at this moment."""
        return self._now

    @property
    def state(self) -> str:
        """One of STATES."""
        return self._now.state

    @property
    def reason(self) -> str:
        """The reason key, "ok" when there is nothing to report."""
        return self._now.reason

    @property
    def detail(self) -> str:
        """One plain line, may be empty."""
        return self._now.detail


class HealthRegistry:
    """All parts' health by name, in the order in which they registered."""

    def __init__(
        self, clock: Clock = time.monotonic, on_change: Callable[[], None] | None = None
    ) -> None:
        """`on_change` is called after every change of any part, from the part's own thread."""
        self._clock = clock
        self._on_change = on_change
        self._lock = threading.Lock()
        self._parts: dict[str, Health] = {}

    def part(self, name: str) -> Health:
        """The health of part `name`, made on first use (it begins as starting)."""
        with self._lock:
            if name not in self._parts:
                self._parts[name] = Health(name, self._clock, self._on_change)
            return self._parts[name]

    def states(self) -> dict[str, HealthState]:
        """{part: health} of every part at this moment."""
        with self._lock:
            return {name: part.now() for name, part in self._parts.items()}

    def as_json(self) -> dict[str, dict[str, object]]:
        """The same as plain JSON values, `since_s` turned into `for_s` (seconds it has lasted).

        `do`: what to do about the reason, in English, when there is something to do; `about` is
        there when it names something.
        """
        result: dict[str, dict[str, object]] = {}
        for name, state in self.states().items():
            row: dict[str, object] = asdict(state)
            row["for_s"] = round(self._clock() - state.since_s, 1)
            del row["since_s"]
            if not state.about:
                del row["about"]
            if do := advice(state.reason):
                row["do"] = do
            result[name] = row
        return result
