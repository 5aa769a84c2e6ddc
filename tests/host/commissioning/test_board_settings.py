"""The board's settings what is refused, and what a board has lost."""

from contextlib import nullcontext

import pytest

from fakeboard import FakeBoard
from gazechair import cli
from gazechair.commissioning.board_settings import BoardSettings, SettingsError, parse
from gazechair.service import board_connection
from gazelink.settings_table import index_of


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
