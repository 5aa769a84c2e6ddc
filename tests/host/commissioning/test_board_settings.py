"""The board's settings from the command line: what is refused, and what a board has lost."""

from contextlib import nullcontext
from pathlib import Path

import pytest

from fakeboard import FakeBoard
from gazechair import cli
from gazechair.commissioning import board_settings
from gazechair.commissioning.board_settings import BoardSettings, SettingsError, parse
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
    monkeypatch.setattr(board_settings, "connected", lambda _: link)
    assert cli.main(["settings", "--defaults", "--save"]) == (2 if restarts else 0)
    assert ("the board restarted" in capsys.readouterr().err) is restarts
    assert board.saved[neutral] == 172
    assert (board.saved[linear] == 400) is restarts


def test_no_board_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(board_settings, "_CONNECT_S", 0.3)
    assert cli.main(["settings", "--port", str(tmp_path / "nothing")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("gazechair: no board:")
    assert error.count("\n") == 1
