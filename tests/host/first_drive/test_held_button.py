"""The held button of the first drive: how long one proof of holding counts."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from gazechair.board.state import BoardId
from gazechair.first_drive.held_button import HeldButton, Pressed
from gazesim.board_limits import LIMITS


def test_a_proof_counts_as_long_as_the_board_lets_a_command_live() -> None:
    now_s = 10.0
    board = BoardId("board", "1.2.3", True, 1, 1, replace(LIMITS, command_ttl_ms=120))
    link: Any = SimpleNamespace(board=lambda: board, command=lambda _command: None)
    held = HeldButton(link, lambda: now_s, lambda _client: 0.0)
    assert held.press(1, 1, now_s) is Pressed.ANEW
    now_s = 10.11
    assert held.alive
    now_s = 10.13
    assert not held.alive


def test_without_a_board_nothing_counts() -> None:
    link: Any = SimpleNamespace(board=lambda: None, command=lambda _command: None)
    held = HeldButton(link, lambda: 10.0, lambda _client: 0.0)
    held.press(1, 1, 10.0)
    assert not held.alive
