"""The plan that is being computed, usually on a thread; a newer request takes its place."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from threading import Event

from gazechair.going.path import NoPath, Path

Planned = Path | NoPath
Submit = Callable[[Callable[[], Planned]], Future[Planned]]
"""Runs one job after another, in the order in which they come."""


class Planning:
    """Computes at most one plan that anybody waits for."""

    def __init__(self, submit: Submit) -> None:
        self._submit = submit
        self._pending: Future[Planned] | None = None
        self._over = Event()

    @property
    def busy(self) -> bool:
        """Whether a plan is awaited."""
        return self._pending is not None

    def begin(self, job: Callable[[Callable[[], bool]], Planned]) -> None:
        """Compute a plan, while none is awaited.

        `job` is told by its argument whether nobody waits for it any more.
        """
        over = self._over = Event()
        self._pending = self._submit(lambda: job(over.is_set))

    def abandon(self) -> None:
        """Nobody waits for the pending plan any more; it ends soon, and is never taken."""
        self._over.set()
        self._pending = None

    def take(self) -> Planned | None:
        """The plan, once it is ready; None: not yet, or none is awaited.

        Raises what the planner raised, once.
        """
        if self._pending is None or not self._pending.done():
            return None
        ready, self._pending = self._pending, None
        return ready.result()
