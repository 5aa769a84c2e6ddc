"""Connecting to the board for a command of the terminal."""

from pathlib import Path

import pytest

from gazechair import cli
from gazechair.service import board_connection


def test_no_board_is_said_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(board_connection, "_CONNECT_S", 0.3)
    assert cli.main(["settings", "--port", str(tmp_path / "nothing")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("gazechair: no board:")
    assert error.count("\n") == 1
