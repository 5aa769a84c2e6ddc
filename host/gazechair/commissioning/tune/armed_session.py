"""Drives the board as the caretaker, for procedures that move the chair automatically.

Only within `armed()`; however that ends, the chair is stopped and driving is off.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Protocol

from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.board.state import BoardId, BoardState
from gazechair.commissioning.board_settings import DRIVING
from gazechair.commissioning.tune import StoppedError, TuneError
from gazelink import codes

_POLL_S = 0.002
_ARM_S = 3.0
_FAREWELL_S = 0.25  # orders are repeated this long
_SILENT_S = 0.5


class Link(Protocol):
    """What this needs from gazechair.board.link.BoardLink."""

    def command(self, command: Command) -> None:
        """The latest command."""

    def order(self, action: int, owner: int) -> None:
        """Arm, disarm."""

    def state(self) -> BoardState | None:
        """The newest state, None while there is no board."""

    def board(self) -> BoardId | None:
        """The board and its limits, None while there is none."""


@dataclass(frozen=True)
class Hands:
    """A procedure's means to drive."""

    link: Link
    clock: Callable[[], float]
    wait: Callable[[float], None]
    """Sleeps for seconds of `clock`."""
    aborted: Callable[[], bool]
    """Polled all the time: True stops the chair at once."""
    say: Callable[[str], None]
    """Gets each line for the user."""
    number: Callable[[], int] | None = None
    """Numbers presses for the board, where others press in the same session, too."""


class ArmedSession:
    """Base of all procedures. All methods raise TuneError."""

    def __init__(self, hands: Hands) -> None:
        self._number = hands.number
        self._link = hands.link
        self._clock = hands.clock
        self._wait = hands.wait
        self._aborted = hands.aborted
        self._say = hands.say
        self._edge = 0
        self._last: BoardState | None = None
        self._received_s = 0.0

    @contextlib.contextmanager
    def armed(self) -> Iterator[BoardId]:
        """Armed by the caretaker; stopped and disarmed at the end."""
        board = self._link.board()
        if board is None:
            raise _gone()
        self._ttl_s = board.limits.command_ttl_ms / 1000
        try:
            self._arm()
            self._received_s = self._clock()
            yield board
        finally:
            self._link.command(STOP_COMMAND)
            self._link.order(codes.DISARM, codes.CARETAKER)
            self._wait(_FAREWELL_S)

    def _arm(self) -> None:
        state = self._state()
        if state.state != codes.DISARMED:
            raise TuneError(DRIVING, "board_armed")
        if state.arm_reason:
            text = "the board is not ready: {reason}; see gazechair doctor"
            raise TuneError(text, "board_not_ready", reason=state.arm_reason_name)
        self._edge = state.edge
        self._link.order(codes.ARM, codes.CARETAKER)
        end_s = self._clock() + _ARM_S
        while self._state().state != codes.ARMED:
            if self._clock() > end_s:
                text, why = "the board does not arm: {reason}", self._state().arm_reason_name
                raise TuneError(text, "board_no_arm", reason=why)
            self._pause()

    def _next(self) -> BoardState | None:
        """Wait a moment; a newer state of the armed board with a valid heading, or None."""
        self._pause()
        state = self._state()
        if state.state != codes.ARMED:
            why = state.override_name if state.override else state.arm_reason_name
            text = "the board switched driving off: {reason}; clear that and repeat"
            raise TuneError(text, "board_off", reason=why)
        if not state.heading_known:
            raise TuneError("the heading sensor failed; see gazechair doctor", "heading_failed")
        if state is not self._last:
            self._last = state
            self._received_s = self._clock()
            return state
        if self._clock() - self._received_s > _SILENT_S:
            text = "the board has fallen silent; check its cable and repeat"
            raise TuneError(text, "board_silent")
        return None

    def _new_edge(self) -> int:
        self._edge = self._edge % 255 + 1 if self._number is None else self._number()
        return self._edge

    def _renewed(self, command: Command) -> Command:
        return replace(command, ttl_deadline_s=self._clock() + self._ttl_s)

    def _state(self) -> BoardState:
        state = self._link.state()
        if state is None:
            raise _gone()
        return state

    def _pause(self) -> None:
        if self._aborted():
            raise StoppedError
        self._wait(_POLL_S)


def _gone() -> TuneError:
    return TuneError("the board is gone; check its cable and repeat", "board_gone")
