"""Whether the board has confirmed a page's stop by reporting that no motion is requested."""

from __future__ import annotations

ON_ITS_WAY_S = 0.05  # an earlier state may have been sent before the stop arrived


class StopSeen:
    """Counts each page's stops, and those that the board has confirmed. Not thread-safe."""

    def __init__(self) -> None:
        self._requested: dict[int, tuple[int, float]] = {}  # client: how many, when the newest
        self._seen: dict[int, int] = {}

    def requested(self, client: int, now_s: float) -> None:
        """This page has sent a stop."""
        self._requested[client] = (self._requested.get(client, (0, 0.0))[0] + 1, now_s)

    def board(self, stands: bool, received_s: float) -> None:
        """The board's newest state: whether no motion is requested, and when it arrived."""
        if not stands:
            return
        for client, (count, requested_s) in self._requested.items():
            if received_s >= requested_s + ON_ITS_WAY_S:
                self._seen[client] = count

    def seen(self, client: int) -> int:
        """How many of this page's stops the board has confirmed."""
        return self._seen.get(client, 0)

    def all_seen(self) -> int:
        """Changes whenever some page's count does."""
        return sum(self._seen.values())

    def gone(self, client: int) -> None:
        """This page has closed."""
        self._requested.pop(client, None)
        self._seen.pop(client, None)
