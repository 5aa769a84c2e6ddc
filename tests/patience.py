"""Waits in wall time for an expected condition, also on a machine that stalls."""

import time
from collections.abc import Callable
from typing import Any

PATIENCE_S = 60.0


def wait_until(condition: Callable[[], Any], what: str = "it") -> Any:
    """The condition's first true value; the test fails, saying `what`, when it does not come."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        assert time.monotonic() < deadline_s, f"waited {PATIENCE_S:.0f} s in vain: {what}"
        time.sleep(0.005)
    return value
