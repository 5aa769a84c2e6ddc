"""Where step turns ended, to be shown until the selected profile is tuned."""

from __future__ import annotations

from gazechair.base.angles import half_turn_deg
from gazechair.board.board_commands import Command
from gazechair.board.state import BoardState
from gazelink import codes

_SETTLED_S = 0.4  # the chair coasts a little after the last correction


class StepTurns:
    """Follows the board's states; `turned`: result of the last step turn. Not thread-safe."""

    def __init__(self) -> None:
        self.turned: tuple[int, int] | None = None
        """Degrees turned of degrees requested; None while there is none, or the profile is tuned"""
        self._began_deg: float | None = None
        self._rests_deg = 0.0
        self._ended_s: float | None = None
        self._sign = 1

    def board(self, state: BoardState | None, command: Command) -> None:
        """The board's newest state, and the newest command to it."""
        if state is None or state.tuned is not False or not state.heading_known:
            self.turned = self._began_deg = self._ended_s = None
            return
        if state.motion == codes.TURNING:
            self._turning(state, command)
            return
        if state.motion != codes.STOPPED:
            self._began_deg = None
        if self._began_deg is not None and state.step_deg is not None:
            if self._ended_s is None:
                self._ended_s = state.received_s
            elif state.received_s - self._ended_s >= _SETTLED_S:
                turned = half_turn_deg(state.heading_deg - self._began_deg)
                self.turned = round(turned * self._sign), round(state.step_deg)
                self._began_deg = None
        self._rests_deg = state.heading_deg

    def _turning(self, state: BoardState, command: Command) -> None:
        if self._ended_s is not None:
            self._began_deg = None  # another one begins before that came to rest
        self._ended_s = None
        step = command.mode == codes.STEP and command.verb in (codes.LEFT, codes.RIGHT)
        if step and command.edge == state.edge and self._began_deg is None:
            self._began_deg = self._rests_deg
            self._sign = 1 if command.verb == codes.LEFT else -1
            self.turned = None
