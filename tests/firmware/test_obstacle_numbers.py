"""Numbers that obstacles.py, arcs.py and auto.py repeat from other files are the same there."""

from __future__ import annotations

from gazeboard.core import ages, auto, directions, limits, obstacles, stopping, tick
from gazeboard.core import arcs as board_arcs
from gazelink import arcs, codes


def test_the_repeated_numbers_are_the_same() -> None:
    """Directions, decisions, and what limits.py and stopping.py say."""
    directions = (codes.DIR_FORWARD, codes.DIR_BACKWARD, codes.DIR_LEFT, codes.DIR_RIGHT)
    here = (obstacles._FORWARD, obstacles._BACKWARD, obstacles._LEFT, obstacles._RIGHT)
    assert here == directions
    decisions = (codes.FREE, codes.SLOW, codes.BLOCKED)
    here_decided = (obstacles._DECIDED_FREE, obstacles._DECIDED_SLOW, obstacles._DECIDED_BLOCKED)
    assert here_decided == decisions
    assert obstacles._LEVELS == stopping.LEVELS
    assert obstacles._AGE_MAX_MS == limits.AGE_MAX_MS
    assert obstacles._CLEAR_MS == limits.CLEAR_MS
    assert obstacles._AUTO == tick._AUTO == codes.AUTO


def test_the_numbers_of_arcs_are_the_same() -> None:
    """What arcs.py and safety.py repeat, and how its tables lie."""
    here = board_arcs
    rows = (here._ROWS, here._BOTH_ROWS, here._BOTH_AT, here._UNIT_MM)
    assert rows == (arcs.ROWS, arcs.BOTH_ROWS, arcs.BOTH_AT, arcs.UNIT_MM)
    assert (len(arcs.TURNS_DEG), len(arcs.BOTH_TURNS_DEG)) == (arcs.ROWS, arcs.BOTH_ROWS)
    assert arcs.BOTH_AT == arcs.QUADRANTS * arcs.ROWS
    assert arcs.SIZE == arcs.BOTH_AT + arcs.SIDES * arcs.BOTH_ROWS
    assert (here._LEVELS, here._CLEAR_MS) == (stopping.LEVELS, limits.CLEAR_MS)
    assert (here._BAND_MM, here._BAND_Q4) == (limits.BAND_MM, limits.BAND_Q4_DEG)
    assert (here._DRIVE, here._PERIOD_MS) == (codes.DRIVE, obstacles._PERIOD_MS)
    assert here._AUTO == codes.AUTO
    assert here._MOST_AT == arcs.ROWS + arcs.BOTH_ROWS
    assert here._OF_STOPPING == here._STOPS + 2 * here._STEPS
    assert directions.ARC_BLOCKED == obstacles.ARC_BLOCKED


def test_the_numbers_of_auto_are_the_same() -> None:
    """What auto.py repeats."""
    assert (auto._PRESSES, auto._SUPERVISED) == (ages.PRESSES, ages.SUPERVISED)
    assert auto._OVERRULED_MS == limits.AUTO_OVERRULED_MS
    assert ages._AUTO == codes.AUTO
    assert auto._NO_REASON == codes.NO_REASON
