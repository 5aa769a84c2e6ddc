"""Until a profile is tuned: slower turns, and a word about it."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gazechair.board.board_commands import Command
from gazechair.board.state import BoardState
from gazechair.driving import error_handler
from gazechair.driving.untuned import TURN_PERMILLE, slowed
from gazelink import codes

UNTUNED = {"profile": 2, "p3_1_tuned": 0, "step_turn_q4_deg": 160}
STATE = BoardState(codes.ARMED, 0, 0, 0, 0, 0, 350.0, 0, 0, 0, 0, 0, 1.0, settings=UNTUNED)
TUNED = replace(STATE, settings={**UNTUNED, "p3_1_tuned": 1})
LEFT = Command(codes.LEFT, codes.STEP, 5, codes.DRIVER, 2.0)


@pytest.mark.parametrize("verb", [codes.LEFT, codes.RIGHT])
@pytest.mark.parametrize("mode", [codes.STEP, codes.CONTINUOUS])
def test_turns_are_slower(verb: int, mode: int) -> None:
    turn = replace(LEFT, verb=verb, mode=mode)
    assert slowed(turn, STATE).cap_permille == TURN_PERMILLE
    assert slowed(replace(turn, cap_permille=300), STATE).cap_permille == 300
    assert slowed(turn, TUNED) == turn
    assert slowed(turn, None) == turn
    assert slowed(turn, replace(STATE, settings={})) == turn


def test_nothing_else_is_slower() -> None:
    for verb in (codes.STOP, codes.FORWARD, codes.BACKWARD):
        assert slowed(replace(LEFT, verb=verb), STATE).cap_permille == 1000
    tune = replace(LEFT, mode=codes.TUNE)
    assert slowed(tune, STATE) == tune
    drive = Command(codes.DRIVE, codes.CONTINUOUS, 5, codes.DRIVER, 2.0, 900, -900)
    slow = slowed(drive, STATE)
    assert (slow.linear_permille, slow.turn_permille) == (900, -TURN_PERMILLE)
    assert slow.cap_permille == 1000
    assert slowed(replace(drive, turn_permille=300), STATE).turn_permille == 300


@pytest.mark.parametrize("turn", [-1000, 1000])
def test_auto_motions_turn_as_they_ask(turn: int) -> None:
    """Profile 1.2 breaks loose to the right at 593 permille: 600 of the wipers are 586."""
    drive = Command(codes.DRIVE, codes.AUTO, 5, codes.DRIVER, 2.0, 0, turn)
    assert slowed(drive, STATE) == drive


def test_it_is_said_where_all_else_is_well() -> None:
    errors = error_handler.ErrorHandler()
    assert errors.fold(error_handler.of_board(STATE), 1.0).message == "untuned"
    assert errors.fold(error_handler.of_board(STATE), 1.0).level == "ok"
    assert errors.fold(error_handler.of_board(TUNED), 1.0).message == "ok"
    tilted = replace(STATE, override=codes.OBSTACLE_LEFT)
    assert errors.fold(error_handler.of_board(tilted), 1.0).message == "obstacle_left"
