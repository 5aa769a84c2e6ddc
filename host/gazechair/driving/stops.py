"""Stops that clients have sent: when, and whether the board has confirmed them."""

from __future__ import annotations

ON_ITS_WAY_S = 0.05  # an earlier state may have been sent before the stop arrived


class _Newest:
    """When the newest event of some kind came, and from whom."""

    def __init__(self) -> None:
        self._newest_s, self._newest_by = 0.0, 0
        self._before_s = 0.0  # the newest of everybody else

    def came(self, client: int, now_s: float) -> None:
        if client != self._newest_by:
            self._before_s, self._newest_by = self._newest_s, client
        self._newest_s = now_s

    def of_others_s(self, client: int) -> float:
        return self._before_s if client == self._newest_by else self._newest_s


class Stops:
    """When clients last sent a stop of any kind, connected or not; monotonic seconds.

    An auto motion ends as well when anybody presses anything anew.
    """

    def __init__(self) -> None:
        self._stops, self._presses = _Newest(), _Newest()

    def sent(self, client: int, now_s: float) -> None:
        """`client` has sent a stop."""
        self._stops.came(client, now_s)

    def pressed(self, client: int, now_s: float) -> None:
        """`client` has pressed what moves the chair or lets it move, permitted or not."""
        self._presses.came(client, now_s)

    def of_others_s(self, client: int, presses: bool = False) -> float:
        """The newest of anyone but `client`, whose own messages arrive in order; 0: anyone's.

        `presses`: presses count, too.
        """
        stopped_s = self._stops.of_others_s(client)
        return max(stopped_s, self._presses.of_others_s(client)) if presses else stopped_s


class StopSeen:
    """Counts each page's stops, and those that the board has confirmed by reporting that no motion
    is requested. Not thread-safe."""

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
