"""A planner's thread in virtual time: a plan is known some time after its request."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any

PLAN_MS = 300
"""Time that a plan usually takes, by the virtual clock."""


class Thinker(Executor):
    """A plan is known `plan_ms` later, by `now_s`; None: after its own CPU time."""

    def __init__(self, now_s: Callable[[], float], plan_ms: float | None = PLAN_MS) -> None:
        self._now_s = now_s
        self._plan_ms = plan_ms
        self.spent_ms: list[float] = []
        """CPU time of each plan."""

    def submit(self, work: Any, /, *args: Any, **more: Any) -> Future[Any]:
        """Compute at once; the result is ready later."""
        made = Later(self._now_s)
        begin_s = time.process_time()
        try:
            made.set_result(work(*args, **more))
        except Exception as error:
            made.set_exception(error)
        self.spent_ms.append(1000.0 * (time.process_time() - begin_s))
        took_ms = self.spent_ms[-1] if self._plan_ms is None else self._plan_ms
        made.ready_s += took_ms / 1000.0
        return made


class Later(Future[Any]):
    """A result that is not ready before `ready_s`, by `now_s`."""

    def __init__(self, now_s: Callable[[], float]) -> None:
        super().__init__()
        self._now_s, self.ready_s = now_s, now_s()

    def done(self) -> bool:
        """False until the result is due."""
        return self._now_s() >= self.ready_s
