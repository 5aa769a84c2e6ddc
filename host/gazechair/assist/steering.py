"""Applies assist's advice to the driver's command, bounded whatever its process sends. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from gazechair.assist.assist import FULL, MOST_TURN
from gazechair.board.board_commands import Command
from gazelink import codes

OLD_S = 0.15
"""Older advice is ignored: the chair drives straight on, as without assist."""
_FIRST_S = 0.15  # how long a press waits for the first advice, which may not be straight on
_READY_S = 0.6  # how long a report of known surroundings counts
_SHOWN_S = 0.6  # how long a page shows that it steered


@dataclass(frozen=True)
class Advised:
    """Advice from assist's process."""

    press: int
    """The board's number of the press that it is for; 0: no press."""
    linear_permille: int
    turn_permille: int
    steers: bool
    born_s: float
    """When it was made, monotonic; its data was not old then."""
    waits: bool = False
    """It requests nothing because of a possible person."""


class Steering:
    """Steers the driver's pressed *Vooruit*, and nothing else. Not thread-safe.

    A press keeps its verb on the board, so its beginning decides whether assist steers it. A
    steered press is sent as DRIVE, which straight ahead is the same motion as FORWARD.
    """

    def __init__(self) -> None:
        self.advised: Advised | None = None
        """The newest advice."""
        self.ready_s = -math.inf
        """When its process last knew its surroundings."""
        self._edge = 0
        self._assisted = False
        self._first_till_s = 0.0
        self._steered_s = self._waited_s = -math.inf

    def steer(self, command: Command, wanted: bool, now_s: float) -> Command:
        """The command for the board. `wanted`: the driver has assist on."""
        forward = command.verb == codes.FORWARD and command.mode == codes.CONTINUOUS
        if not forward or command.owner != codes.DRIVER:
            self._edge = 0
            return command
        if command.edge != self._edge:
            self._edge = command.edge
            self._assisted = wanted and self.works(now_s)
            self._first_till_s = now_s + _FIRST_S
        if not self._assisted:
            return command
        linear, turn = FULL if now_s >= self._first_till_s or not wanted else 0, 0
        advised = self.advised
        if wanted and advised is not None and self._counts(advised, command, now_s):
            linear = max(0, min(FULL, advised.linear_permille))
            turn = max(-MOST_TURN, min(MOST_TURN, advised.turn_permille))
            self._first_till_s = now_s
            self._waited_s = now_s if advised.waits else -math.inf
            if advised.steers:
                self._steered_s = now_s
        return replace(command, verb=codes.DRIVE, linear_permille=linear, turn_permille=turn)

    @staticmethod
    def _counts(advised: Advised, command: Command, now_s: float) -> bool:
        young = 0.0 <= now_s - advised.born_s <= OLD_S
        return young and advised.press == command.edge and now_s < command.ttl_deadline_s

    def works(self, now_s: float) -> bool:
        """True if its process knows the surroundings: a press that begins now would be steered."""
        return 0.0 <= now_s - self.ready_s <= _READY_S

    def steers(self, now_s: float) -> bool:
        """True if it steers now, or has just done so."""
        return bool(self._edge) and now_s - self._steered_s <= _SHOWN_S

    def waits(self, now_s: float) -> bool:
        """True if it waits now for a possible person: if it is a thing, holding on is enough."""
        return bool(self._edge) and now_s - self._waited_s <= _SHOWN_S
