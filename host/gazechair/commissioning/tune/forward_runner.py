"""Runs the straight presses of a tuning: arms, keeps each active, records, always disarms."""

from __future__ import annotations

from collections.abc import Callable

from gazechair.base.latest_value import Entry
from gazechair.board.board_commands import STOP_COMMAND, Command
from gazechair.board.state import BoardState
from gazechair.commissioning.tune import TuneError
from gazechair.commissioning.tune.armed_session import ArmedSession, Hands
from gazechair.commissioning.tune.forward import ForwardRecording
from gazechair.sensing.odometry.doubts import LATE, STUCK, UNSURE
from gazechair.sensing.odometry.estimate import Estimate
from gazelink import codes

# (highest output, permille; duration, s) of each press.
PRESSES = ((600, 1.2), (400, 1.6), (600, 1.8))
REST_S = 2.0
_SETTLES_S = 1.0
_DOUBTED_S = 0.3
_OLD_S = 1.0

Measured = Callable[[], Entry[Estimate] | None]


class ForwardRunner(ArmedSession):
    """One run."""

    def __init__(
        self, hands: Hands, measured: Measured, begins: Callable[[], None] = lambda: None
    ) -> None:
        """`measured`: odometry's newest estimate; `begins` is called as each press begins."""
        super().__init__(hands)
        self._measured = measured
        self._begins = begins
        self._outputs: list[tuple[float, float]] = []
        self._places: list[tuple[float, float, float]] = []
        self._version = 0
        self._track: int | None = None
        self._sure_s = 0.0

    def run(self) -> list[ForwardRecording]:
        """Record all presses. Raises TuneError with the reason when it ends early; however it ends,
        the chair is stopped and driving is off."""
        found = []
        with self.armed():
            self._sure_s = self._clock()
            self._listen(STOP_COMMAND, _SETTLES_S)
            for cap_permille, seconds in PRESSES:
                begin_s = self._clock() - 0.5
                self._say(f"  straight on at {cap_permille / 10:.0f} % for {seconds:.1f} s")
                self._begins()
                press = Command(
                    codes.FORWARD,
                    codes.CONTINUOUS,
                    self._new_edge(),
                    codes.CARETAKER,
                    0.0,
                    cap_permille=cap_permille,
                )
                self._listen(press, seconds)
                self._listen(STOP_COMMAND, REST_S)
                found.append(
                    ForwardRecording.of(self._outputs, self._places, begin_s, self._clock())
                )
        return found

    def _listen(self, command: Command, seconds: float) -> None:
        end_s = self._clock() + seconds
        while self._clock() < end_s:
            pressed = command is not STOP_COMMAND
            self._link.command(self._renewed(command) if pressed else command)
            state = self._next()
            if state is not None:
                self._note(state, pressed)
            self._look()

    def _note(self, state: BoardState, pressed: bool) -> None:
        self._outputs.append((state.received_s, state.linear_permille / 1000.0))
        if pressed and state.edge == self._edge and state.override:
            raise TuneError(f"the board stopped the chair: {state.override_name}")

    def _look(self) -> None:
        entry = self._measured()
        now_s = self._clock()
        if entry is not None and entry.version != self._version:
            self._version = entry.version
            found = entry.value
            if self._track not in (None, found.track):
                raise TuneError("the lidars have lost the place; repeat where more can be seen")
            self._track = found.track
            if STUCK in found.doubts:
                raise TuneError("the chair does not move; are its brakes engaged?")
            if not (UNSURE - {LATE}).intersection(found.doubts):
                self._sure_s = now_s
            self._places.append((found.time_s, found.x_m, found.y_m))
        if now_s - self._sure_s > (_DOUBTED_S if entry is not None else _OLD_S):
            raise TuneError("the lidars do not tell where the chair is; repeat where more is seen")
