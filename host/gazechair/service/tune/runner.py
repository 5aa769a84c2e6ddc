"""Runs the tuning pulses on the board: arms, holds each pulse up, listens, always ends disarmed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Protocol

from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.board.state import BoardId, BoardState
from gazechair.service.tune.errors import TuneError
from gazechair.service.tune.numbers import TurnNumbers
from gazechair.service.tune.procedure import Procedure
from gazechair.service.tune.recording import Pulse, Recording, Sample
from gazelink import codes

_POLL_S = 0.002
_ARM_S = 3.0
_LAST_WORDS_S = 0.25  # orders are repeated this long
_SILENT_S = 0.5


class Link(Protocol):
    """What it needs of gazechair.board.link.BoardLink."""

    def command(self, command: Command) -> None:
        """The latest command."""

    def order(self, action: int, owner: int) -> None:
        """Arm, disarm."""

    def state(self) -> BoardState | None:
        """The newest state, None while there is no board."""

    def board(self) -> BoardId | None:
        """The board and its limits, None while there is none."""


class Runner:
    """One run. `aborted` is polled all the time: True stops the chair at once."""

    def __init__(
        self,
        link: Link,
        clock: Callable[[], float],
        wait: Callable[[float], None],
        aborted: Callable[[], bool],
        say: Callable[[str], None],
    ) -> None:
        """`wait` lets seconds of `clock` pass; `say` gets each line for the user."""
        self._link = link
        self._clock = clock
        self._wait = wait
        self._aborted = aborted
        self._say = say
        self._edge = 0
        self._ttl_s = 0.0
        self._last: BoardState | None = None
        self._ms = 0
        self._heading_deg = 0.0

    def run(self, believed: TurnNumbers, neutral_count: int) -> list[Recording]:
        """Record all pulses. TuneError with the reason when it ends early; however it ends, the
        chair is stopped and driving is off."""
        board = self._link.board()
        if board is None:
            raise _gone()
        self._ttl_s = board.limits.command_ttl_ms / 1000
        procedure = Procedure(believed, neutral_count, board.limits)
        try:
            self._arm()
            self._follow(procedure)
        finally:
            self._link.command(STOP_COMMAND)
            self._link.order(codes.DISARM, codes.CARETAKER)
            self._wait(_LAST_WORDS_S)
        return procedure.recordings

    def _arm(self) -> None:
        state = self._state()
        if state.state != codes.DISARMED:
            raise TuneError("driving is on; switch it off first (Rijden uit)")
        if state.arm_reason:
            raise TuneError(
                f"the board is not ready: {state.arm_reason_name}; see gazechair doctor"
            )
        self._edge = state.edge
        self._link.order(codes.ARM, codes.CARETAKER)
        end_s = self._clock() + _ARM_S
        while self._state().state != codes.ARMED:
            if self._clock() > end_s:
                raise TuneError(f"the board does not arm: {self._state().arm_reason_name}")
            self._pause()

    def _follow(self, procedure: Procedure) -> None:
        held: Pulse | None = None
        command = STOP_COMMAND
        heard_s = self._clock()
        while not procedure.done:
            self._pause()
            state = self._state()
            if state.state != codes.ARMED:
                why = state.override_name if state.override else state.arm_reason_name
                raise TuneError(f"the board switched driving off: {why}; clear that and repeat")
            if not state.heading_known:
                raise TuneError("the heading sensor failed; see gazechair doctor")
            if state is not self._last:
                heard_s = self._clock()
                procedure.sample(self._sample(state))
            elif self._clock() - heard_s > _SILENT_S:
                raise TuneError("the board has fallen silent; check its cable and repeat")
            if procedure.wanted is not held:
                held = procedure.wanted
                command = STOP_COMMAND if held is None else self._press(held)
                if held is not None:
                    self._say(f"  {_words(held)}")
            if held is not None:
                command = self._held(command)
            self._link.command(command)

    def _press(self, pulse: Pulse) -> Command:
        self._edge = self._edge % 255 + 1
        return Command(
            codes.LEFT if pulse.turn_permille > 0 else codes.RIGHT,
            codes.TUNE,
            self._edge,
            codes.CARETAKER,
            0.0,
            turn_permille=pulse.turn_permille,
            pulse_ms=pulse.pulse_ms,
        )

    def _held(self, command: Command) -> Command:
        return replace(command, ttl_deadline_s=self._clock() + self._ttl_s)

    def _sample(self, state: BoardState) -> Sample:
        """The state with clock and heading counted on over their wraps."""
        if self._last is not None:
            self._ms += (state.board_ms - self._last.board_ms) & 0xFFFF
            turned = state.heading_deg - self._last.heading_deg
            self._heading_deg += (turned + 180.0) % 360.0 - 180.0
        self._last = state
        # A value left from an earlier press does not apply to this one.
        override = state.override if state.edge == self._edge else codes.NO_REASON
        return Sample(self._ms, self._heading_deg, state.turn_permille, override)

    def _state(self) -> BoardState:
        state = self._link.state()
        if state is None:
            raise _gone()
        return state

    def _pause(self) -> None:
        if self._aborted():
            raise TuneError("stopped; nothing was changed")
        self._wait(_POLL_S)


def _gone() -> TuneError:
    return TuneError("the board is gone; check its cable and repeat")


def _words(pulse: Pulse) -> str:
    side = "left" if pulse.turn_permille > 0 else "right"
    return f"{side}, {abs(pulse.turn_permille) / 10:.0f} %, {pulse.pulse_ms / 1000:.2f} s"
