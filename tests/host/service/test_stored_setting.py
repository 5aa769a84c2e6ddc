"""A setting of the board is in force and in its flash, or in neither."""

from __future__ import annotations

import pytest

from fakeboard import FakeBoard
from gazechair.service.board_settings import BoardSettings, SettingsError
from gazechair.service.stored_setting import store
from gazelink import codes
from gazelink.settings_table import index_of

PROFILE = index_of("profile")


def test_it_is_in_force_and_in_the_flash() -> None:
    board = FakeBoard()
    store(BoardSettings(board), PROFILE, 4)  # type: ignore[arg-type]
    assert board.values[PROFILE] == board.saved[PROFILE] == 4


@pytest.mark.parametrize("refused", [codes.SETTING_SET, codes.SETTING_SAVE])
def test_what_is_refused_is_in_neither(refused: int) -> None:
    board = FakeBoard()
    before = list(board.values)
    wrong = iter([codes.SETTING_NOT_STORED])
    board.refuses = lambda request, _: next(wrong, 0) if request == refused else 0
    with pytest.raises(SettingsError):
        store(BoardSettings(board), PROFILE, 4)  # type: ignore[arg-type]
    assert board.values == before
    assert board.saved == []


def test_what_was_stored_unheard_is_in_neither() -> None:
    board = FakeBoard()
    before = list(board.values)
    board.unanswered_saves = 3  # as often as it is asked
    with pytest.raises(SettingsError, match="does not answer"):
        store(BoardSettings(board), PROFILE, 4)  # type: ignore[arg-type]
    assert board.values == board.saved == before


def test_a_board_that_restarts_before_it_saves_has_stored_nothing_and_it_is_told() -> None:
    board = FakeBoard()
    before = list(board.values)
    board.restarts = True
    with pytest.raises(SettingsError, match="restarted"):
        store(BoardSettings(board), PROFILE, 4)  # type: ignore[arg-type]
    assert board.values == board.saved == before


def test_what_was_stored_unheard_and_then_refused_is_in_neither() -> None:
    board = FakeBoard()
    before = list(board.values)
    board.unanswered_saves = 1
    saves = iter([0, codes.SETTING_NOT_STORED])
    board.refuses = lambda request, _: next(saves, 0) if request == codes.SETTING_SAVE else 0
    with pytest.raises(SettingsError, match="could not write it"):
        store(BoardSettings(board), PROFILE, 4)  # type: ignore[arg-type]
    assert board.values == board.saved == before
