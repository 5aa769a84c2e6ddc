"""What Control needs from parts that it does not own: the link to the board, and the alerts."""

from __future__ import annotations

from typing import Protocol

from gazechair.board.board_commands import Bypass, Clearance, Command
from gazechair.board.state import BoardId, BoardState, BoardStats


class Link(Protocol):
    """What Control needs from the link to the board (gazechair.board.link.BoardLink)."""

    def command(self, command: Command) -> None: ...
    def order(self, action: int, owner: int) -> None: ...
    def clearance(self, clearance: Clearance) -> None: ...
    def bypass(self, bypass: Bypass | None) -> None: ...
    def state(self) -> BoardState | None: ...
    def stats(self) -> BoardStats | None: ...
    def board(self) -> BoardId | None: ...


class Calls(Protocol):
    """What Control needs from the alerts (gazechair.alerts.service.Alerts)."""

    help_wanted: bool
    answered_s: float | None

    @property
    def revision(self) -> int: ...
    def reaches_somebody(self) -> bool: ...
