"""Writes the trace of a virtual board: from its app, tick by tick."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gazereplay import trace
from gazereplay.trace import Taken

# Gets a topic of the trace and the fields of its message.
Say = Callable[[str, dict[str, Any]], None]


class Tap:
    """One run of one board, from before its first tick."""

    def __init__(self, app: Any, say: Say) -> None:
        """`app` is a gazeboard.app.App that has not ticked yet."""
        self._app = app
        self._core = app.core
        self._say = say
        self._tick = 0
        self._i: Any = None
        self._around: tuple[int, ...] = ()
        self._last_taken: Taken | None = None
        self._last_decision: tuple[int, ...] | None = None
        self._last_service = 0
        self._decide, self._written = app.core.decide, app.core.written
        self._apply, self._raised = app._apply_settings, app.core.raised
        app.core.decide, app.core.written = self._on_decide, self._on_written
        app._apply_settings, app.core.raised = self._on_settings, self._on_raised
        simulated = bool(app._board.simulated)
        faults = app.safety.faults
        start = {"settings": app.settings.text(), "simulated": simulated, "boot_faults": faults}
        say(trace.START, start)

    def _on_decide(self, i: Any, elapsed_us: int, *contacts: bool) -> None:
        self._i = i
        self._around = (elapsed_us, *(int(contact) for contact in contacts))
        self._decide(i, elapsed_us, *contacts)

    def _on_written(self, verified: bool, neutral: bool) -> int:
        before = self._core.enable_level
        level: int = self._written(verified, neutral)
        i = self._i
        taken = Taken(
            (*self._around, int(verified), int(neutral)),
            tuple(int(getattr(i, name)) for name in trace.TAKEN),
            bytes(i.clearance_arcs),
            i.service_count != self._last_service,
        )
        self._last_service = i.service_count
        if taken != self._last_taken:
            self._last_taken = taken
            self._say(trace.INPUTS, taken.fields(self._tick))
        decided = trace.decision(self._core, level != before)
        if decided != self._last_decision:
            self._last_decision = decided
            named = dict(zip(trace.DECIDED, decided, strict=True))
            self._say(trace.DECISION, {"tick": self._tick, **named})
        self._tick += 1
        return level

    def _on_settings(self) -> None:
        self._apply()
        text = self._app.settings.text()
        self._say(trace.SETTINGS, {"tick": self._tick, "settings": text})

    def _on_raised(self) -> None:
        self._raised()
        self.end("an exception in the tick")

    def end(self, reason: str) -> None:
        """Record that the last tick has passed, so that exactly those are replayed."""
        self._say(trace.ENDED, {"tick": self._tick, "reason": reason})
