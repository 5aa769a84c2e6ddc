"""The first drive's own motions: the relay's test, and a first slow turn to each side."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.base.angles import half_turn_deg
from gazechair.board.board_commands import Command
from gazechair.board.state import BoardState, BoardStats
from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.armed_session import ArmedSession, Hands
from gazechair.driving.untuned import TURN_PERMILLE
from gazelink import codes

_RELAY_S = 3.0  # the board reports its relay once a second
_PASSES_S = 0.2  # until a report describes the state after the change
_BEGINS_S = 1.0
_ENDS_S = 12.0
_SETTLES_S = 0.6


class Moves(ArmedSession):
    """One motion at a time; all raise TuneError."""

    def __init__(self, hands: Hands, stats: Callable[[], BoardStats | None]) -> None:
        super().__init__(hands)
        self._stats = stats

    def relay(self) -> None:
        """Check that the relay is closed while armed, and open otherwise. Nothing drives."""
        with self.armed():
            self._sees(True)
        self._sees(False)

    def turns(self) -> tuple[float, float]:
        """A step to the left and one back to the right, slowly; degrees turned, left positive."""
        with self.armed():
            return self._turn(codes.LEFT), self._turn(codes.RIGHT)

    def _sees(self, closed: bool) -> None:
        since_s = self._clock()
        while self._clock() < since_s + _RELAY_S:
            self._pause()
            if closed:
                self._next()
            stats = self._stats()
            if stats is None or stats.received_s < since_s + _PASSES_S:
                continue
            if bool(stats.counters["relay"]) == closed:
                return
        if closed:
            text = "the relay was not reported closed; check its feedback contact"
            raise TuneError(text, "relay_not_closed")
        raise TuneError(
            "the relay was not reported open; check its feedback contact", "relay_not_open"
        )

    def _turn(self, verb: int) -> float:
        command = Command(
            verb,
            codes.STEP,
            self._new_edge(),
            codes.CARETAKER,
            0.0,
            cap_permille=TURN_PERMILLE,
        )
        start_deg = self._state().heading_deg
        began_s = ended_s = self._clock()
        moved = False
        while not moved or self._clock() < ended_s + _SETTLES_S:
            self._link.command(self._renewed(command))
            state = self._next()
            now_s = self._clock()
            if state is not None and state.edge == command.edge and state.motion != codes.STOPPED:
                moved, ended_s = True, now_s
            if state is not None and state.edge == command.edge:
                self._overruled(state)
            if now_s > began_s + (_ENDS_S if moved else _BEGINS_S):
                text = "the board does not turn the chair; repeat, with free space around"
                raise TuneError(text, "turn_none")
        return half_turn_deg(self._state().heading_deg - start_deg)

    def _overruled(self, state: BoardState) -> None:
        # A turn that ends off its mark is a result, which this step shows.
        if state.override not in (codes.NO_REASON, codes.TIME_LIMIT):
            text = "the board stopped the turn: {reason}"
            raise TuneError(text, "turn_stopped", reason=state.override_name)
