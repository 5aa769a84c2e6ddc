"""The output of `gazechair tune`, and what it stores: everything or nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import pytest

from gazechair.commissioning.board_settings import SettingRefused, SettingsError
from gazechair.commissioning.tune import StoppedError, TuneError, tuning
from gazechair.commissioning.tune.forward import ForwardNumbers, ForwardRecording
from gazechair.commissioning.tune.numbers import TurnNumbers
from gazechair.commissioning.tune.recording import Recording
from gazechair.commissioning.tune.tuning import Tuning
from gazelink import codes
from gazelink.settings_table import PROFILES, TABLE, index_of
from gazemeasure.turn.board import settings_with
from gazemeasure.turn.tuning import record
from gazesim.chair import Chair
from gazesim.imu_model import Imu, ImuErrors
from gazesim.profiles import undisturbed
from remembered import remembered

# What it is made of takes longer than the tests: one process makes it.
pytestmark = pytest.mark.xdist_group("tune_command")


class MemoryBoard:
    """Settings in memory, refused after `refuses_after` changes."""

    def __init__(self) -> None:
        self.values = [row[1] for row in TABLE]
        self.saved: list[int] | None = None
        self.refuses_after = 1 << 30
        self.full = False
        self.unheard: SettingsError | None = None  # the next SAVE is done, and ends like this
        self.gone = False  # it answers no more, once `refuses_after` is over
        self.interrupted_at: list[int] = []  # Ctrl-C in these requests, counted from 1
        self.requests = 0

    def all(self) -> list[int]:
        return list(self.values)

    def set(self, index: int, value: int) -> None:
        _, _, low, high = TABLE[index]
        assert low <= value <= high
        self.refuses_after -= 1
        self._interrupt()
        if self.refuses_after == 0:
            raise SettingsError("set: the board does not answer")
        if self.gone and self.refuses_after < 0:
            raise SettingsError("set: the board does not answer")
        self.values[index] = value

    def save(self, values: Mapping[int, int]) -> None:
        if self.full:
            text = "save refused: the board could not write it to its flash"
            raise SettingRefused(text, codes.SETTING_NOT_STORED)
        self.saved = list(self.values)
        unheard, self.unheard = self.unheard, None
        if unheard:
            raise unheard
        self._interrupt()

    def _interrupt(self) -> None:
        self.requests += 1
        if self.requests in self.interrupted_at:
            raise KeyboardInterrupt


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    """Of an undisturbed chair in profile 3.1."""
    chair = Chair("3.1", 1, undisturbed("3.1"))
    return record(chair, Imu(ImuErrors()), settings_with({}), "3.1")


@pytest.fixture(scope="module", autouse=True)
def computed_once() -> Iterator[None]:
    """These pulses give the same numbers every time, after a second of computing."""
    with remembered(tuning, "identify", lambda pulses, believed: (id(pulses), believed)):
        yield


@pytest.fixture
def board() -> MemoryBoard:
    return MemoryBoard()


def tune(
    board: MemoryBoard,
    recordings: list[Recording],
    profile: str = "3.1",
    dry_run: bool = False,
    go: bool = True,
    straight: Callable[[], Sequence[ForwardRecording]] | None = None,
) -> str:
    printed: list[str] = []

    def measured(believed: TurnNumbers, neutral_count: int) -> list[Recording]:
        assert neutral_count == 170
        return recordings

    Tuning(board, measured, printed.append, lambda: go, straight).run(profile, dry_run)
    return "\n".join(printed)


def test_what_is_found_is_stored_for_that_profile_alone(
    board: MemoryBoard, recordings: list[Recording]
) -> None:
    before = board.all()
    printed = tune(board, recordings)
    changed = {TABLE[k][0] for k, value in enumerate(board.values) if value != before[k]}
    assert all(name.startswith("p3_1_") for name in changed - {"profile"})
    assert board.values[index_of("p3_1_tuned")] == 1
    assert board.values[index_of("profile")] == PROFILES.index("3.1")
    assert board.saved == board.values
    assert "free all round" in printed
    assert "stops it at once" in printed
    assert "braking while driving forward stays 500 mm/s2: it cannot be measured" in printed
    assert TurnNumbers.of("3.1", board.values).left_dps == pytest.approx(45.5, rel=0.06)


def straight_on() -> list[ForwardRecording]:
    """As a chair of known numbers drives."""
    time_s = np.arange(0.0, 5.0, 0.01)
    share = np.where((time_s > 0.5) & (time_s < 2.5), 0.6, 0.0)
    way = ForwardNumbers(0.36, 0.08, 0.15, 0.3, 0.6, 1.0).ways(share)
    return [ForwardRecording(time_s, share, time_s[::5], way[::5])]


def test_driving_straight_on_is_stored_with_it(
    board: MemoryBoard, recordings: list[Recording]
) -> None:
    printed = tune(board, recordings, straight=straight_on)
    assert "three metres free ahead" in printed
    assert "a step forward goes 0.50 m in profile 3.1" in printed
    assert board.values[index_of("p3_1_forward_mm_s")] == pytest.approx(378, rel=0.1)
    assert board.values[index_of("step_forward_ms")] == pytest.approx(2850, rel=0.05)
    assert board.saved == board.values


def test_what_cannot_be_driven_straight_on_keeps_its_braking_and_a_stop_keeps_all(
    board: MemoryBoard, recordings: list[Recording]
) -> None:
    def blocked() -> list[ForwardRecording]:
        raise TuneError("the board stopped the chair: obstacle_forward")

    def stopped() -> list[ForwardRecording]:
        raise StoppedError

    before = board.all()
    with pytest.raises(StoppedError):
        tune(board, recordings, straight=stopped)
    assert (board.values, board.saved) == (before, None)
    printed = tune(board, recordings, straight=blocked)
    assert "stays 500 mm/s2: the board stopped the chair: obstacle_forward" in printed
    assert board.values[index_of("p3_1_tuned")] == 1
    assert board.values[index_of("p3_1_brake_mm_s2")] == 500


def test_a_dry_run_shows_and_changes_nothing(
    board: MemoryBoard, recordings: list[Recording]
) -> None:
    before = board.all()
    printed = tune(board, recordings, dry_run=True)
    assert "before" in printed
    assert "found" in printed
    assert "dry run: nothing was changed" in printed
    assert (board.values, board.saved) == (before, None)


def test_without_a_go_nothing_moves(board: MemoryBoard) -> None:
    with pytest.raises(TuneError, match="nobody said go"):
        tune(board, [], go=False)


def test_another_profile_is_refused_and_nothing_stored(
    board: MemoryBoard, recordings: list[Recording]
) -> None:
    before = board.all()
    with pytest.raises(TuneError, match=r"not as profile 1\.2 does, rather as"):
        tune(board, recordings, profile="1.2")
    assert (board.values, board.saved) == (before, None)


@pytest.mark.parametrize("refuses_after", [1, 5, 1 << 30])
def test_what_cannot_be_stored_leaves_the_settings_as_before(
    board: MemoryBoard, recordings: list[Recording], refuses_after: int
) -> None:
    before = board.all()
    board.refuses_after = refuses_after
    board.full = True
    with pytest.raises(TuneError, match=r"not stored: .*; the settings are as before"):
        tune(board, recordings)
    assert board.values == before


@pytest.mark.parametrize(
    "how",
    [
        SettingsError("save: the board does not answer"),
        SettingRefused("save refused: driving is on", codes.SETTING_WHILE_ARMED, unheard=True),
    ],
    ids=["no answer", "refused at the next try"],
)
def test_what_was_stored_unheard_is_put_back_in_the_flash_too(
    board: MemoryBoard, recordings: list[Recording], how: SettingsError
) -> None:
    before = board.all()
    board.unheard = how
    with pytest.raises(TuneError, match=r"not stored: .*; the settings are as before"):
        tune(board, recordings)
    assert board.values == board.saved == before


@pytest.mark.parametrize("changes", range(1, 14))
def test_a_tuning_cut_off_while_it_is_stored_leaves_a_profile_that_is_not_tuned(
    board: MemoryBoard, recordings: list[Recording], changes: int
) -> None:
    tuned = index_of("p3_1_tuned")
    board.values[tuned] = 1
    before = board.all()
    board.refuses_after, board.gone = changes, True
    try:
        tune(board, recordings)
    except TuneError:
        assert board.values == before or board.values[tuned] == 0
    else:
        assert board.saved == board.values


def test_ctrl_c_while_it_is_stored_leaves_all_as_before(recordings: list[Recording]) -> None:
    whole = MemoryBoard()
    tune(whole, recordings)
    assert whole.requests >= 10
    for at in range(1, whole.requests + 1):
        board = MemoryBoard()
        before = board.all()
        board.interrupted_at = [at]
        with pytest.raises(KeyboardInterrupt):
            tune(board, recordings)
        assert board.values == before, at
        assert board.saved in (None, before), at


def test_ctrl_c_again_while_it_is_undone_says_that_it_is_not(recordings: list[Recording]) -> None:
    board = MemoryBoard()
    board.interrupted_at = [5, 7]
    with pytest.raises(TuneError, match=r"not stored \(stopped\), .* could not be put back"):
        tune(board, recordings)
    assert board.values[index_of("p3_1_tuned")] == 0


def test_numbers_and_settings_are_the_same_thing() -> None:
    for profile in PROFILES:
        default = TurnNumbers.default(profile)
        values = [row[1] for row in TABLE]
        for name, value in default.rows(profile).items():
            values[index_of(name)] = value
        again = TurnNumbers.of(profile, values)
        assert np.allclose(list(vars(again).values()), list(vars(default).values()))
