"""The settings of a connected board: read, change, save; refusals in plain language."""

from __future__ import annotations

from collections.abc import Mapping

from gazechair.base.user_error import UserError
from gazechair.board.link import BoardLink
from gazechair.board.setting_request import ask
from gazechair.board.state import BoardState
from gazelink import codes
from gazelink.settings_table import NAMES, TABLE, index_of

_TRIES, _ANSWER_S = 3, 1.0
_GAP_S = 3.0  # a gap in the link, as on a busy computer, may last so long
DRIVING = "driving is on; switch it off first (Rijden uit)"
_REFUSALS = {
    codes.SETTING_UNKNOWN: "the board knows no such setting; flash it with this version",
    codes.SETTING_OUT_OF_RANGE: "the value is outside the limits shown by gazechair settings",
    codes.SETTING_WHILE_ARMED: DRIVING,
    codes.SETTING_NOT_STORED: "the board could not write it to its flash; is it full?",
    codes.SETTING_BY_CALIBRATION: "set neutral first: gazechair calibrate joystick, with a meter",
    codes.SENSOR_NOT_CALIBRATED: "the sensor says it is not calibrated; move it gently every way",
}


class SettingsError(UserError):
    """A refusal or a board that does not answer: one line, what and what to do."""


class SettingRefused(SettingsError):
    """The board refused; `reason` is its code (gazelink.codes).

    `unheard`: an earlier try got no answer, and may have been done.
    """

    def __init__(self, text: str, reason: int, unheard: bool = False) -> None:
        super().__init__(text)
        self.reason = reason
        self.unheard = unheard


def may_be_done(error: BaseException) -> bool:
    """Whether the board may have done the request that ended like this."""
    return not isinstance(error, SettingRefused) or error.unheard


def parse(name: str, text: str) -> tuple[int, int]:
    """(index, value) of a change given as text. SettingsError for an unknown name or bad value."""
    if name not in NAMES:
        raise SettingsError(f"no setting {name!r}; there are {', '.join(NAMES)}")
    index = index_of(name)
    _, _, low, high = TABLE[index]
    if not text.isdecimal() or not low <= int(text) <= high:
        raise SettingsError(f"{name} must be a whole number {low}..{high}, not {text!r}")
    return index, int(text)


class BoardSettings:
    """The settings of a connected board. Every method raises SettingsError when it is refused."""

    def __init__(self, link: BoardLink) -> None:
        self._link = link

    def state(self) -> BoardState | None:
        """The newest state that the board sent, None while it is not connected."""
        return self._link.state()

    def all(self) -> list[int]:
        """The values in force, in the order of the table."""
        return [self.get(index) for index in range(len(TABLE))]

    def get(self, index: int) -> int:
        """The value in force."""
        return self._ask(codes.SETTING_GET, index)

    def set(self, index: int, value: int) -> None:
        """Put a value in force at once; it is kept across a reset only after save()."""
        self._ask(codes.SETTING_SET, index, value)

    def set_neutral(self, index: int, value: int) -> None:
        """Put one of the joystick's neutral counts in force; driving is off until save()."""
        self._ask(codes.SETTING_SET_NEUTRAL, index, value)

    def defaults(self) -> None:
        """Put all defaults in force, but the joystick's neutral."""
        self._ask(codes.SETTING_DEFAULTS)

    def save(self, values: Mapping[int, int]) -> None:
        """Write what is in force to the board's flash; `values`, {index: value}, must still be.

        A board that restarts before it saves, or drops a neutral, has lost what was set.
        """
        self._ask(codes.SETTING_SAVE)
        if any(self.get(index) != value for index, value in values.items()):
            text = "not saved: the board restarted or lost its connection meanwhile; try again"
            raise SettingsError(text, "board_restarted")

    def save_heading(self) -> None:
        """Keep the heading sensor's calibration across a reset."""
        self._ask(codes.SETTING_SAVE_HEADING)

    def _ask(self, request: int, index: int = 0, value: int = 0) -> int:
        what = codes.SETTING_REQUESTS[request]
        answer = ask(
            self._link, request, index, value, tries=_TRIES, answer_s=_ANSWER_S, gap_s=_GAP_S
        )
        if answer.value is not None:
            return answer.value
        if answer.refused:
            reason = _REFUSALS.get(answer.refused, codes.reason_name(answer.refused))
            text = f"{what} {NAMES[index]} refused: {reason}"
            raise SettingRefused(text, answer.refused, answer.unheard)
        text = "{what}: the board does not answer; is its firmware of this version?"
        raise SettingsError(text, "board_no_answer", what=what)
