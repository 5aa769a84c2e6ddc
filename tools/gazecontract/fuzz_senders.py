"""The senders of the fuzz (page, device), and the link that only records."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from gazechair.board.board_commands import STOP_COMMAND, Bypass, Clearance, Command
from gazechair.board.state import BoardId, BoardState, BoardStats
from gazechair.plugins import NOTHING, Intent
from gazechair.plugins.value_checks import InputRun
from gazecontract.sender_oracle import Motion
from gazelink import codes
from gazesim.board_limits import LIMITS

QUIET = BoardState(0, 0, 0, 0, 0, 0, 90.0, 0, 12, 0, 0, 0, 0.0)


class Link:
    """Stands for the daemon's link: the last command sent, and the board's state."""

    def __init__(self) -> None:
        self.now = QUIET
        self.begin(1)
        self.sent = STOP_COMMAND
        self.orders: list[int] = []

    def begin(self, session: int) -> None:
        """A new session of the board."""
        self.who: BoardId | None = BoardId("fuzz", "0", False, 1, session, LIMITS)

    def command(self, command: Command) -> None:
        self.sent = command

    def order(self, action: int, owner: int) -> None:
        self.orders.append(action)

    def clearance(self, clearance: Clearance) -> None: ...

    def bypass(self, bypass: Bypass | None) -> None: ...

    def state(self) -> BoardState | None:
        return self.now

    def stats(self) -> BoardStats | None:
        return None

    def board(self) -> BoardId | None:
        return self.who


@dataclass
class Page:
    """A page and its press."""

    role: str
    client: int
    name: str
    life: int = 0
    edge: int = 0
    held: dict[str, Any] | None = None


@dataclass
class Device:
    """An input and its last value."""

    role: str
    name: str
    life: InputRun
    lives: int = 0
    press: int = 0
    stops: int = 0
    rested_s: float = 0.0
    nothing_s: float | None = None
    began_s: float = 100.0
    born_s: float = 0.0
    intent: Intent = field(default_factory=lambda: NOTHING)


def motion_of(held: dict[str, Any]) -> Motion:
    """The motion that a page's message requests."""
    if held["k"] == "drive":
        return codes.DRIVE, codes.CONTINUOUS, held["linear"], held["turn"]
    return codes.VERBS.index(held["verb"]), codes.MODES.index(held["mode"]), 0, 0


def meaning_of(intent: Intent) -> Motion:
    """The motion that an intent requests."""
    if intent.do == "drive":
        out = (intent.linear_permille, intent.turn_permille)
        return codes.DRIVE, codes.CONTINUOUS, *out
    mode = codes.STEP if intent.do == "step" else codes.CONTINUOUS
    return codes.VERBS.index(intent.what), mode, 0, 0
