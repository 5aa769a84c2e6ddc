"""The board's settings as automatic motions use them: never older than driving has been on."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest

from controlrig import QUIET
from gazechair.board.events import SettingReply
from gazechair.board.state import BoardState
from gazechair.producers.chair_settings import ChairSettings
from gazelink import codes
from gazelink.settings_table import TABLE


class Board:
    """A link to a board; `reads`: how many settings it was asked for."""

    def __init__(self) -> None:
        self.values = {row[0]: row[1] for row in TABLE}
        self.now_s = 100.0
        self.safety = codes.DISARMED
        self.session = 1
        self.answers = True
        self.reads = 0
        self.settings = ChairSettings(self)

    def state(self) -> BoardState:
        return replace(QUIET, state=self.safety, received_s=self.now_s)

    def board(self) -> Any:
        return SimpleNamespace(session=self.session)

    def setting(
        self, request: int, index: int = 0, value: int = 0, timeout_s: float = 1.0
    ) -> SettingReply | None:
        assert request == codes.SETTING_GET
        self.reads += 1
        found = self.values[TABLE[index][0]]
        return SettingReply(request, index, found, 0) if self.answers else None

    def runs(self, seconds: float) -> None:
        for _ in range(round(seconds / 0.02)):
            self.now_s += 0.02
            self.settings.refresh()

    @property
    def most(self) -> int | None:
        """The output limit as known."""
        known = self.settings.known
        return None if known is None else known["linear_permille"]


@pytest.fixture
def board() -> Board:
    made = Board()
    made.runs(1.0)
    return made


def test_a_change_just_before_driving_is_switched_on_counts(board: Board) -> None:
    before = board.most
    board.values["linear_permille"] = 321
    board.runs(0.1)
    assert board.most == before  # not read again yet
    board.safety = codes.ARMING
    board.runs(0.02)
    assert board.most == 321
    board.safety = codes.ARMED
    reads = board.reads
    board.runs(60.0)
    assert board.reads == reads  # nothing can have changed


def test_unknown_while_the_board_has_not_answered_since_then(board: Board) -> None:
    board.values["linear_permille"] = 321
    board.answers = False
    board.safety = codes.ARMED
    reads = board.reads
    board.runs(3.0)
    assert board.most is None
    assert board.reads - reads <= 4  # each may block for its time limit
    board.answers = True
    board.runs(1.1)
    assert board.most == 321


def test_switched_off_they_are_read_again_now_and_then_and_kept_meanwhile(board: Board) -> None:
    board.answers = False
    before = board.most
    board.values["linear_permille"] = 321
    board.runs(10.0)
    assert board.most == before
    board.answers = True
    board.runs(5.1)
    assert board.most == 321


def test_another_session_that_begins_while_driving_is_on_is_read(board: Board) -> None:
    board.safety = codes.ARMED
    board.runs(1.0)
    board.session, board.answers = 2, False
    board.runs(0.02)
    assert board.most is None
    board.answers = True
    board.runs(1.1)
    assert board.most is not None
