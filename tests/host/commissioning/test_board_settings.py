"""The board's settings: what is refused, what a board has lost, and a gap in its link."""

from contextlib import nullcontext

import pytest

from fakeboard import FakeBoard
from gazechair import cli
from gazechair.board.state import BoardState
from gazechair.commissioning import board_settings
from gazechair.commissioning.board_settings import BoardSettings, SettingsError, parse
from gazechair.service import board_connection
from gazelink.settings_table import TABLE, index_of


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("speed", "1", "no setting 'speed'; there are neutral_linear_count"),
        ("linear_permille", "1001", "must be a whole number 50..1000, not '1001'"),
        ("linear_permille", "-5", "must be a whole number"),
        ("linear_permille", "fast", "must be a whole number"),
        ("linear_permille", "3.5", "must be a whole number"),
    ],
)
def test_bad_words_are_refused_before_the_board_is_asked(name: str, text: str, reason: str) -> None:
    with pytest.raises(SettingsError, match=reason):
        parse(name, text)


@pytest.mark.parametrize("restarts", [False, True])
def test_defaults_that_a_board_lost_before_it_saved_are_not_called_saved(
    restarts: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    board = FakeBoard()
    linear, neutral = index_of("linear_permille"), index_of("neutral_turn_count")
    board.values[linear], board.values[neutral] = 400, 172
    board.saved = list(board.values)
    board.restarts = restarts
    link = nullcontext(BoardSettings(board))  # type: ignore[arg-type]
    monkeypatch.setattr(board_connection, "connected", lambda _: link)
    assert cli.main(["settings", "--defaults", "--save"]) == (2 if restarts else 0)
    assert ("the board restarted" in capsys.readouterr().err) is restarts
    assert board.saved[neutral] == 172
    assert (board.saved[linear] == 400) is restarts


class AwayFor(FakeBoard):
    """A board whose link has a gap: it is back when it was looked for so often."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self.looks = looks

    def state(self) -> BoardState | None:
        self.looks -= 1
        self.connected = self.looks < 0
        return super().state()


def test_a_gap_in_the_link_is_waited_out() -> None:
    index = index_of("linear_permille")
    assert BoardSettings(AwayFor(5)).get(index) == TABLE[index][1]  # type: ignore[arg-type]


def test_a_board_that_stays_away_does_not_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(board_settings, "_GAP_S", 0.1)
    with pytest.raises(SettingsError, match="the board does not answer"):
        BoardSettings(AwayFor(10**9)).get(0)  # type: ignore[arg-type]
