"""The board's settings from the command line: what is refused before a board is asked."""

from pathlib import Path

import pytest

from gazechair import cli
from gazechair.service import board_settings
from gazechair.service.board_settings import SettingsError, parse


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


def test_no_board_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(board_settings, "_CONNECT_S", 0.3)
    assert cli.main(["settings", "--port", str(tmp_path / "nothing")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("gazechair: no board:")
    assert error.count("\n") == 1
