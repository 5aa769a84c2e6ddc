"""Runs the tuning pulses on the board: arms, keeps each pulse active, records, always disarms."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.base.angles import half_turn_deg
from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.board.state import BoardState
from gazechair.commissioning.tune.armed_session import ArmedSession, Hands
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.procedure import Procedure
from gazechair.commissioning.tune.recording import Pulse, Recording, Sample
from gazelink import codes


class Runner(ArmedSession):
    """One run."""

    def __init__(self, hands: Hands, begins: Callable[[], None] = lambda: None) -> None:
        """`begins` is called as each pulse begins."""
        super().__init__(hands)
        self._begins = begins
        self._before: BoardState | None = None
        self._ms = 0
        self._heading_deg = 0.0

    def run(self, believed: TurnNumbers, neutral_count: int) -> list[Recording]:
        """Record all pulses. Raises TuneError with the reason when it ends early; however it ends,
        the chair is stopped and driving is off."""
        with self.armed() as board:
            procedure = Procedure(believed, neutral_count, board.limits)
            self._follow(procedure)
        return procedure.recordings

    def _follow(self, procedure: Procedure) -> None:
        active: Pulse | None = None
        command = STOP_COMMAND
        while not procedure.done:
            state = self._next()
            if state is not None:
                procedure.sample(self._sample(state))
            if procedure.wanted is not active:
                active = procedure.wanted
                command = STOP_COMMAND if active is None else self._press(active)
                if active is not None:
                    self._say(f"  {_text_of(active)}")
                    self._begins()
            if active is not None:
                command = self._renewed(command)
            self._link.command(command)

    def _press(self, pulse: Pulse) -> Command:
        return Command(
            codes.LEFT if pulse.turn_permille > 0 else codes.RIGHT,
            codes.TUNE,
            self._new_edge(),
            codes.CARETAKER,
            0.0,
            turn_permille=pulse.turn_permille,
            pulse_ms=pulse.pulse_ms,
        )

    def _sample(self, state: BoardState) -> Sample:
        """The state with unwrapped clock and heading."""
        if self._before is not None:
            self._ms += (state.board_ms - self._before.board_ms) & 0xFFFF
            turned = state.heading_deg - self._before.heading_deg
            self._heading_deg += half_turn_deg(turned)
        self._before = state
        # A value left from an earlier press does not apply to this one.
        override = state.override if state.edge == self._edge else codes.NO_REASON
        return Sample(self._ms, self._heading_deg, state.turn_permille, override)


def _text_of(pulse: Pulse) -> str:
    side = "left" if pulse.turn_permille > 0 else "right"
    return f"{side}, {abs(pulse.turn_permille) / 10:.0f} %, {pulse.pulse_ms / 1000:.2f} s"
