"""Nobody arms while settings of the board are stored, and nothing is stored while somebody does."""

from __future__ import annotations

import pytest

from fakeboard import FakeBoard
from gazechair.board.caretaker_settings import CaretakerSettings, ChangeRefused
from gazechair.driving.storing import Storing
from gazelink import codes
from gazelink.settings_table import index_of

VALUES = {"linear_permille": 1000}
LINEAR = index_of("linear_permille")


def test_who_wants_to_arm_between_setting_and_saving_may_not() -> None:
    """Armed, the board refuses to save, and to set back."""
    board, storing = FakeBoard(), Storing(lambda: False)
    may: list[bool] = []

    def arms(request: int, _index: int) -> int:
        with storing.arm() as free:
            may.append(free)
            board.armed = board.armed or (free and request == codes.SETTING_SAVE)
        return codes.SETTING_WHILE_ARMED if board.armed else 0

    board.refuses = arms
    CaretakerSettings(board, storing=storing.store).change(VALUES)
    assert board.values == board.saved
    assert board.saved[LINEAR] == 1000
    stores = codes.SETTING_GET, codes.SETTING_SET, codes.SETTING_SAVE
    assert may[: len(stores)] == [False] * len(stores)
    with storing.arm() as free:
        assert free


@pytest.mark.parametrize("lost", [True, False])
def test_after_a_refusal_everybody_may_arm_again(lost: bool) -> None:
    board, storing = FakeBoard(), Storing(lambda: False)
    board.loses = lambda request, *_: lost and request == codes.SETTING_SAVE
    board.refuses = lambda request, _: request == codes.SETTING_SAVE and codes.SETTING_NOT_STORED
    with pytest.raises(ChangeRefused):
        CaretakerSettings(board, storing=storing.store).change(VALUES)
    with storing.arm() as free:
        assert free


def test_while_somebody_is_about_to_drive_nothing_is_stored() -> None:
    """The board may not have armed for them yet."""
    board, storing = FakeBoard(), Storing(lambda: True)
    before = list(board.values)
    with pytest.raises(ChangeRefused) as refused:
        CaretakerSettings(board, storing=storing.store).change(VALUES)
    assert refused.value.reason == "setting_while_armed"
    assert (board.values, board.saved) == (before, [])
    with storing.arm() as free:  # they do not wait for that
        assert free
