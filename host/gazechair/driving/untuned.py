"""Slows turns until the selected profile is tuned.

Untuned, the board uses default values for the chair's turning. On 30 random simulated chairs a
step of 10 degrees ended up to 3.9 degrees off at 60 % deflection, up to 15.5 at full; at 35 %
some did not begin to turn. This makes turns better, not safer: the board enforces every limit.
Auto motions are not slowed: odometry shows them how far they have turned, and a smaller output may
not turn the chair at all (profile 1.2 breaks loose to the right at 593 permille).
"""

from __future__ import annotations

from dataclasses import replace

from gazechair.board.board_commands import Command
from gazechair.board.state import BoardState
from gazelink import codes

TURN_PERMILLE = 600
_TURNS = (codes.LEFT, codes.RIGHT)
_OF_THEIR_OWN = (codes.TUNE, codes.AUTO)
"""Modes of motions that know how fast they may turn."""


def slowed(command: Command, state: BoardState | None) -> Command:
    """The same command, with slower turns while the profile is known not to be tuned."""
    if state is None or state.tuned is not False or command.mode in _OF_THEIR_OWN:
        return command
    if command.verb in _TURNS:
        return replace(command, cap_permille=min(command.cap_permille, TURN_PERMILLE))
    if command.verb == codes.DRIVE and abs(command.turn_permille) > TURN_PERMILLE:
        turn = TURN_PERMILLE if command.turn_permille > 0 else -TURN_PERMILLE
        return replace(command, turn_permille=turn)
    return command
