"""Records stalls of the machine itself, so that a benchmark can exclude them."""

from __future__ import annotations

import threading
import time
from pathlib import Path

_PERIOD_S = 0.001
STALL_S = 0.005  # longer than this between two looks is a stall


def waited_s(pid: int) -> float:
    """How long the main thread of `pid` was ready but got no processor; 0.0 when it ended."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text().split()[1]) / 1e9
    except OSError:
        return 0.0


class StallProbe:
    """A thread that reads the clock every millisecond; use as a context."""

    def __init__(self) -> None:
        self._stalls: list[tuple[float, float]] = []
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stall-probe", daemon=True)

    def __enter__(self) -> StallProbe:
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self._stopping.set()
        self._thread.join(5.0)

    def _run(self) -> None:
        last_s = time.monotonic()
        while not self._stopping.is_set():
            time.sleep(_PERIOD_S)
            now_s = time.monotonic()
            if now_s - last_s > STALL_S:
                self._stalls.append((last_s, now_s))
            last_s = now_s

    def stalled(self, start_s: float, end_s: float) -> bool:
        """True if a stall overlaps the time from `start_s` to `end_s` (CLOCK_MONOTONIC)."""
        return any(a < end_s and start_s < b for a, b in list(self._stalls))
