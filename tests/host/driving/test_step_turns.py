"""Where a step turn ended, until a profile is tuned."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from gazechair.board.board_commands import Command
from gazechair.board.state import BoardState
from gazechair.driving.step_turns import StepTurns
from gazelink import codes

UNTUNED = {"profile": 2, "p3_1_tuned": 0, "step_turn_q4_deg": 160}
STATE = BoardState(codes.ARMED, 0, 0, 0, 0, 0, 350.0, 0, 0, 0, 0, 0, 1.0, settings=UNTUNED)
LEFT = Command(codes.LEFT, codes.STEP, 5, codes.DRIVER, 2.0)


def turn(turns: StepTurns, command: Command = LEFT, end_deg: float = 357.0, **more: Any) -> None:
    """From 350 degrees, with this command, to there."""
    for at_s, motion, heading_deg in (
        (1.0, codes.STOPPED, 350.0),
        (1.1, codes.TURNING, 352.0),
        (2.0, codes.TURNING, 356.0),
        (2.1, codes.STOPPED, 356.5),
        (2.6, codes.STOPPED, end_deg),
    ):
        state = replace(
            STATE, motion=motion, heading_deg=heading_deg, received_s=at_s, edge=command.edge
        )
        turns.board(replace(state, **more), command)


def test_where_a_step_ended_is_told() -> None:
    turns = StepTurns()
    turn(turns)
    assert turns.turned == (7, 10)
    turn(turns, replace(LEFT, edge=6), 2.0)  # over north
    assert turns.turned == (12, 10)
    turn(turns, replace(LEFT, verb=codes.RIGHT, edge=7), 341.0)
    assert turns.turned == (9, 10)


def test_only_steps_of_an_untuned_chair_are_told() -> None:
    turns = StepTurns()
    turn(turns, replace(LEFT, mode=codes.CONTINUOUS))
    assert turns.turned is None
    turn(turns, settings={**UNTUNED, "p3_1_tuned": 1})
    assert turns.turned is None
    turn(turns, faults=codes.HEADING_FAULTS)
    assert turns.turned is None
    turn(turns)
    turns.board(None, LEFT)
    assert turns.turned is None
