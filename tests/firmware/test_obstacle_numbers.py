"""Numbers that obstacles.py repeats from other files are the same there."""

from __future__ import annotations

from gazeboard import limits, obstacles, stopping
from gazelink import codes


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
