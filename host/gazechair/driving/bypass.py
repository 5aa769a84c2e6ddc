"""The caretaker's bypass button: which press the board receives, and for how long. Pure."""

from __future__ import annotations

from dataclasses import replace

from gazechair.board.board_commands import Bypass


class BypassButton:
    """One press at a time. A press that ended never counts again, as with a drive command."""

    def __init__(self, last_number: int) -> None:
        """`last_number`: presses are numbered on from here, 0..255; random at each start."""
        self._number = last_number
        self._client = 0
        self._edges: dict[int, int] = {}  # newest edge seen of each client
        self._held: Bypass | None = None

    @property
    def held(self) -> Bypass | None:
        """What the board receives, None: not pressed."""
        return self._held

    def hold(self, client: int, edge: int, deadline_s: float) -> bool:
        """The press `edge` of `client` is active, proven until `deadline_s`; False: it ended."""
        if edge > self._edges.get(client, 0):
            self._edges[client] = edge
            self._number = self._number % 255 + 1  # 0 is none
            self._client = client
            self._held = Bypass(self._number, deadline_s)
            return True
        if self._held is None or client != self._client or edge != self._edges[client]:
            return False
        latest_s = max(deadline_s, self._held.ttl_deadline_s)
        self._held = replace(self._held, ttl_deadline_s=latest_s)
        return True

    def let_go(self, client: int) -> None:
        """The client does not hold it any more; another's press stays."""
        if client == self._client:
            self._held = None

    def gone(self, client: int) -> None:
        """The client has left."""
        self.let_go(client)
        self._edges.pop(client, None)

    def tick(self, now_s: float) -> None:
        """Let time act: a press that is not proven any more has ended."""
        if self._held is not None and now_s >= self._held.ttl_deadline_s:
            self._held = None
