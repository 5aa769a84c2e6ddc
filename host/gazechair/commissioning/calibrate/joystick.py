"""Sets the joystick's neutral with a meter at the unplugged DB9."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from gazechair.board.state import BoardState
from gazechair.commissioning.board_settings import DRIVING, SettingsError, may_be_done, parse
from gazechair.commissioning.calibrate.errors import CalibrateError
from gazelink import codes
from gazelink.settings_table import TABLE, index_of

CONFIRMATION = "unplugged"
_MILLIVOLT_A_COUNT = 11.8  # docs/wiring.md
# (setting, what it is called, pin of the DB9)
_CHANNELS = (("neutral_linear_count", "linear", 1), ("neutral_turn_count", "turn", 2))
_READ_BACK_S = 3.0
_SETTLED_S = 0.05  # the board calls a wrong read-back a fault after a few ticks
_POLL_S = 0.01


class Board(Protocol):
    """What it needs of board_settings.BoardSettings."""

    def state(self) -> BoardState | None:
        """The newest state."""

    def all(self) -> list[int]:
        """The values in force."""

    def set_neutral(self, index: int, value: int) -> None:
        """Put a neutral count in force."""

    def save(self, values: Mapping[int, int]) -> None:
        """Write what is in force to the board's flash; `values` must still be."""


class JoystickCalibration:
    """One run. `say` gets each line for the user; `read_line` gives their next, "" at the end."""

    asks = ""
    """What is to be answered now: "unplugged", "linear", "turn" or "save"."""

    def __init__(
        self,
        board: Board,
        say: Callable[[str], None],
        read_line: Callable[[], str],
        clock: Callable[[], float] = time.monotonic,
        wait: Callable[[float], None] = time.sleep,
        storing: Callable[[], contextlib.AbstractContextManager[bool]] = (
            lambda: contextlib.nullcontext(True)
        ),
    ) -> None:
        """`storing` prevents arming, see driving.storing; False: somebody drives."""
        self._board = board
        self._say = say
        self._read_line = read_line
        self._clock = clock
        self._wait = wait
        self._storing = storing
        self._counts: list[int] = []
        self._changed = False

    def run(self) -> None:
        """Guide the user through both channels and save.

        Raises CalibrateError or SettingsError. If it ends before saving, the counts are restored,
        unless the text says otherwise.
        """
        calibrated = not self._check_state().faults >> codes.CALIBRATION & 1
        values = self._board.all()
        before = [values[index_of(name)] for name, _, _ in _CHANNELS]
        self._counts = list(before)
        self._confirm_unplugged()
        saving = saved = False
        # Arming is prevented from the storing until what failed is set back.
        with contextlib.ExitStack() as storing:
            try:
                for channel in range(len(_CHANNELS)):
                    self._adjust(channel)
                self._say(
                    f"linear {self._counts[0]}, turn {self._counts[1]}: type 'save' to keep them"
                )
                if self._answer("save") != "save":
                    raise CalibrateError("not saved; the counts are as before", "neutral_not_saved")
                if not storing.enter_context(self._storing()):
                    raise CalibrateError(DRIVING, "board_armed")
                # Straight before the save: other requests may have changed the values meanwhile.
                counts = _indexed(self._counts)
                for index, count in counts.items():
                    self._set(index, count)
                saving = True
                self._board.save(counts)
                saved = True
            except SettingsError as error:
                saving = saving and may_be_done(error)
                raise
            finally:
                if self._changed and not saved:
                    # Counts that were not measured are not saved: they would count as calibrated.
                    self._restore(before, saving and calibrated)
        self._say("saved; measure both pins against pin 3 once more before the DB9 is plugged in")

    def _check_state(self) -> BoardState:
        state = self._state()
        if state.state != codes.DISARMED:
            raise CalibrateError(DRIVING, "board_armed")
        self._check_read_back(state)
        return state

    def _state(self) -> BoardState:
        state = self._board.state()
        if state is None:
            raise CalibrateError("the board is gone; check its cable and repeat", "board_gone")
        return state

    def _check_read_back(self, state: BoardState) -> None:
        if state.faults >> codes.WIPER & 1:
            raise CalibrateError(
                "the potentiometer does not read back what is written (fault wiper); check its"
                " supply, SDA, SCL and pull-ups, then switch the board off and on",
                "neutral_wiper",
            )

    def _confirm_unplugged(self) -> None:
        self._say("this moves the joystick's neutral: a chair on the DB9 would drive")
        self._say(f"pull the DB9 plug, switch the 12 V of a bench supply on, type '{CONFIRMATION}'")
        if self._answer(CONFIRMATION) != CONFIRMATION:
            text = "the DB9 was not confirmed as unplugged; nothing was changed"
            raise CalibrateError(text, "neutral_plugged")

    def _adjust(self, channel: int) -> None:
        name, what, pin = _CHANNELS[channel]
        self._say(f"{what}: meter's red lead on pin {pin} of the DB9's socket, black on pin 8")
        self._say("wanted: 6.00 V, and within 30 mV of what pin 3 shows")
        _, _, low, high = TABLE[index_of(name)]
        self._say(
            f"type + or - for a count ({_MILLIVOLT_A_COUNT} mV), a number {low}..{high},"
            " 'ok' when the meter shows it, 'quit' to leave all as before"
        )
        self._show(channel)
        while True:
            answer = self._answer(what)
            if answer == "ok":
                return
            if answer == "quit":
                raise CalibrateError("not saved; the counts are as before", "neutral_not_saved")
            steps = {"+": 1, "-": -1}
            if answer in steps:
                answer = str(self._counts[channel] + steps[answer])
            try:
                index, count = parse(name, answer)
            except SettingsError as error:
                self._say(f"{error}; it stays {self._counts[channel]}")
                continue
            self._set(index, count)
            self._counts[channel] = count
            self._show(channel)

    def _set(self, index: int, count: int) -> None:
        was, self._changed = self._changed, True
        try:
            self._board.set_neutral(index, count)
        except SettingsError as error:
            self._changed = was or may_be_done(error)
            raise

    # Waits for a state that is newer than the change.
    def _show(self, channel: int) -> None:
        since_s = self._clock() + _SETTLED_S
        end_s = since_s + _READ_BACK_S
        while True:
            state = self._state()
            output = [state.linear_permille, state.turn_permille]
            if state.received_s >= since_s:
                self._check_read_back(state)
                if output == [0, 0]:
                    break
            if self._clock() > end_s:
                raise CalibrateError(
                    "the board puts out {output} permille, not neutral {counts}; check that nothing"
                    " drives it",
                    "neutral_driven",
                    output=str(output),
                    counts=str(self._counts),
                )
            self._wait(_POLL_S)
        self._say(
            f"{_CHANNELS[channel][1]}: neutral {self._counts[channel]}, the register reads back"
            f" {self._counts[channel]} (a register, not a voltage: trust the meter)"
        )

    def _answer(self, asks: str) -> str:
        self.asks = asks
        line = self._read_line()
        if not line:
            text = "no more input; not saved, the neutral counts are as before"
            raise CalibrateError(text, "neutral_not_saved")
        return line.strip().lower()

    def _restore(self, before: list[int], save: bool) -> None:
        """`save`: the new counts may be in the flash."""
        try:
            for index, count in _indexed(before).items():
                self._board.set_neutral(index, count)
            if save:
                self._board.save(_indexed(before))
        except (SettingsError, KeyboardInterrupt) as error:
            raise CalibrateError(
                "the neutral counts could not be put back ({error}); switch the board off and on,"
                " it then starts with what it saved",
                "neutral_lost",
                error=str(error) or "stopped",
            ) from None
        self._say(f"back at linear {before[0]}, turn {before[1]}")


def _indexed(counts: Sequence[int]) -> dict[int, int]:
    """{setting: count} of both channels."""
    return {index_of(name): count for (name, _, _), count in zip(_CHANNELS, counts, strict=True)}
