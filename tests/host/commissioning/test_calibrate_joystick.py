"""`gazechair calibrate joystick` with a board in memory: guided, within limits, never half done."""

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext

import pytest

from gazechair.board.state import BoardState
from gazechair.commissioning.board_settings import SettingRefused, SettingsError
from gazechair.commissioning.calibrate import joystick
from gazechair.commissioning.calibrate.errors import CalibrateError
from gazechair.commissioning.calibrate.joystick import JoystickCalibration
from gazelink import codes
from gazelink.settings_table import TABLE, index_of

LINEAR, TURN = index_of("neutral_linear_count"), index_of("neutral_turn_count")
STORED = (168, 171)


class MemoryBoard:
    """A disarmed board whose outputs follow its settings."""

    def __init__(self) -> None:
        self.values = [row[1] for row in TABLE]
        self.values[LINEAR], self.values[TURN] = STORED
        self.saved: tuple[int, int] | None = None
        self.safety = codes.DISARMED
        self.faults = 0
        self.connected = True
        self.full = False
        self.unheard: BaseException | None = None  # the next SAVE is done, then this is raised
        self.refuses_after: int | None = None
        self.refusal: BaseException = SettingsError("set: the board does not answer")
        self.follows = True
        self.sets = 0

    @property
    def counts(self) -> tuple[int, int]:
        return self.values[LINEAR], self.values[TURN]

    def state(self) -> BoardState | None:
        if not self.connected:
            return None
        output = (0, 0) if self.follows else (24, -12)
        now_s = time.monotonic()
        return BoardState(self.safety, 0, 0, 0, 0, self.faults, 0.0, *output, 0, 0, 0, now_s)

    def all(self) -> list[int]:
        return list(self.values)

    def set_neutral(self, index: int, value: int) -> None:
        self.sets += 1
        if self.refuses_after is not None and self.sets > self.refuses_after:
            raise self.refusal
        self.values[index] = value

    def save(self, values: Mapping[int, int]) -> None:
        if self.full:
            text = "save refused: the board could not write it to its flash"
            raise SettingRefused(text, codes.SETTING_NOT_STORED)
        self.saved = self.counts
        unheard, self.unheard = self.unheard, None
        if unheard is not None:
            raise unheard


@pytest.fixture
def board(monkeypatch: pytest.MonkeyPatch) -> Iterator[MemoryBoard]:
    monkeypatch.setattr(joystick, "_SETTLED_S", 0.0)
    monkeypatch.setattr(joystick, "_READ_BACK_S", 0.2)
    made = MemoryBoard()
    yield made
    assert made.values[2:] == [row[1] for row in TABLE][2:], "nothing else is ever changed"


def run(board: MemoryBoard, *words: str, at: Callable[[int], None] = lambda _: None) -> str:
    """The lines it said; `at(n)` is called before the user's n-th word."""
    lines: list[str] = []
    given = iter([*[f"{word}\n" for word in words], ""])
    count = 0

    def read_line() -> str:
        nonlocal count
        at(count)
        count += 1
        return next(given)

    try:
        JoystickCalibration(board, lines.append, read_line).run()
    finally:
        printed = "\n".join(lines)
        print(printed)
    return printed


def test_both_channels_are_stepped_and_saved(board: MemoryBoard) -> None:
    printed = run(board, "unplugged", "+", "+", "-", "ok", "166", "OK ", "save")
    assert board.saved == (169, 166)
    assert "pull the DB9 plug" in printed
    assert "linear: neutral 169, the register reads back 169" in printed
    assert "turn: neutral 166, the register reads back 166" in printed
    assert "a register, not a voltage" in printed
    assert "6.00 V" in printed
    assert "pin 1" in printed
    assert "pin 2" in printed
    assert "11.8 mV" in printed


@pytest.mark.parametrize("word", ["191", "149", "0", "170.5", "up", "", "++", "-5"])
def test_other_words_and_counts_outside_the_table_are_refused(
    board: MemoryBoard, word: str
) -> None:
    printed = run(board, "unplugged", word, "ok", "ok", "save")
    assert board.saved == STORED
    assert "neutral_linear_count must be a whole number 150..190" in printed
    assert "it stays 168" in printed


def test_counts_that_are_right_already_are_set_all_the_same(board: MemoryBoard) -> None:
    """A board with damaged settings keeps none that was not."""
    run(board, "unplugged", "ok", "ok", "save")
    assert board.saved == STORED
    assert board.sets == 2


def test_stepping_ends_at_the_limits(board: MemoryBoard) -> None:
    printed = run(board, "unplugged", "190", "+", "ok", "150", "-", "ok", "save")
    assert board.saved == (190, 150)
    assert "not '191'" in printed
    assert "not '149'" in printed


@pytest.mark.parametrize(
    "words",
    [
        ("unplugged", "175", "quit"),
        ("unplugged", "175"),
        ("unplugged", "175", "ok", "160", "quit"),
        ("unplugged", "175", "ok", "160", "ok"),
        ("unplugged", "175", "ok", "160", "ok", "no"),
    ],
)
def test_ending_before_the_saving_leaves_all_as_before(
    board: MemoryBoard, words: tuple[str, ...]
) -> None:
    with pytest.raises(CalibrateError, match="as before"):
        run(board, *words)
    assert board.counts == STORED
    assert board.saved is None


@pytest.mark.parametrize("words", [(), ("yes",), ("",)])
def test_nothing_is_changed_unless_the_db9_is_unplugged(
    board: MemoryBoard, words: tuple[str, ...]
) -> None:
    with pytest.raises(CalibrateError):
        run(board, *words)
    assert board.sets == 0


@pytest.mark.parametrize("state", [codes.ARMING, codes.ARMED])
def test_an_armed_board_is_left_alone(board: MemoryBoard, state: int) -> None:
    board.safety = state
    with pytest.raises(CalibrateError, match="driving is on; switch it off first"):
        run(board, "unplugged", "175", "ok", "ok", "save")
    assert board.sets == 0


def test_a_board_that_cannot_store_it_gets_its_old_counts(board: MemoryBoard) -> None:
    board.full = True
    with pytest.raises(SettingsError, match="could not write"):
        run(board, "unplugged", "175", "ok", "ok", "save")
    assert board.counts == STORED


_UNHEARD = (SettingsError("save: the board does not answer"), KeyboardInterrupt())


@pytest.mark.parametrize("how", _UNHEARD, ids=["no answer", "ctrl-c"])
def test_counts_that_were_stored_unheard_are_set_back_in_the_flash_too(
    board: MemoryBoard, how: BaseException
) -> None:
    board.unheard = how
    with pytest.raises(type(how)):
        run(board, "unplugged", "175", "ok", "ok", "save")
    assert board.counts == board.saved == STORED


def test_counts_that_nobody_measured_are_not_stored_instead(board: MemoryBoard) -> None:
    board.faults = 1 << codes.CALIBRATION
    board.unheard = _UNHEARD[0]
    with pytest.raises(SettingsError):
        run(board, "unplugged", "175", "ok", "ok", "save")
    assert board.counts == STORED
    assert board.saved == (175, STORED[1])


def test_what_was_refused_from_the_first_on_needs_nothing_set_back(board: MemoryBoard) -> None:
    board.refuses_after = 0
    board.refusal = SettingRefused("set refused: driving is on", codes.SETTING_WHILE_ARMED)
    with pytest.raises(SettingRefused, match="driving is on"):
        run(board, "unplugged", "+")
    assert (board.counts, board.sets) == (STORED, 1)


def test_while_somebody_is_about_to_drive_nothing_is_stored(board: MemoryBoard) -> None:
    given = iter(["unplugged", "ok", "ok", "save"])
    calibration = JoystickCalibration(
        board, print, lambda: next(given), storing=lambda: nullcontext(False)
    )
    with pytest.raises(CalibrateError, match="driving is on"):
        calibration.run()
    assert (board.sets, board.saved) == (0, None)


def test_nobody_arms_until_what_failed_is_set_back(board: MemoryBoard) -> None:
    storing = False
    while_storing = []

    @contextmanager
    def stored() -> Iterator[bool]:
        nonlocal storing
        storing = True
        try:
            yield True
        finally:
            storing = False

    class Watched(MemoryBoard):
        def set_neutral(self, index: int, value: int) -> None:
            super().set_neutral(index, value)
            while_storing.append(storing)

    watched = Watched()
    watched.unheard = _UNHEARD[0]
    given = iter(["unplugged", "175", "ok", "ok", "save"])
    with pytest.raises(type(_UNHEARD[0])):
        JoystickCalibration(watched, print, lambda: next(given), storing=stored).run()
    assert watched.counts == watched.saved == STORED
    assert while_storing == [False, True, True, True, True]  # moved; set anew; set back
    assert not storing


def test_ctrl_c_gives_the_old_counts_back(board: MemoryBoard) -> None:
    def interrupt(word: int) -> None:
        if word == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(board, "unplugged", "175", at=interrupt)
    assert board.counts == STORED


def test_a_register_that_does_not_read_back_ends_it(board: MemoryBoard) -> None:
    def fail(word: int) -> None:
        if word == 1:
            board.faults = 1 << codes.WIPER

    with pytest.raises(CalibrateError, match="does not read back"):
        run(board, "unplugged", "175", at=fail)
    assert board.counts == STORED


def test_wipers_that_stand_elsewhere_end_it(board: MemoryBoard) -> None:
    board.follows = False
    with pytest.raises(CalibrateError, match=r"puts out \[24, -12\] permille"):
        run(board, "unplugged")
    assert board.counts == STORED


def test_a_board_that_went_away_is_said_with_what_to_do(board: MemoryBoard) -> None:
    board.refuses_after = 1
    with pytest.raises(CalibrateError, match=r"could not be put back .*; switch the board off and"):
        run(board, "unplugged", "175", "176")
    assert board.saved is None


def test_a_second_ctrl_c_while_the_counts_are_put_back_is_said_with_what_to_do(
    board: MemoryBoard,
) -> None:
    def interrupt(word: int) -> None:
        if word == 2:
            raise KeyboardInterrupt

    board.refuses_after, board.refusal = 1, KeyboardInterrupt()
    with pytest.raises(
        CalibrateError, match=r"could not be put back \(stopped\); switch the board"
    ):
        run(board, "unplugged", "175", at=interrupt)
    assert board.counts != STORED


def test_an_unplugged_board_is_one_line(board: MemoryBoard) -> None:
    board.connected = False
    with pytest.raises(CalibrateError, match="the board is gone"):
        run(board)
