"""Inputs of a mode (the press, the board's state, the clearance), and its answer."""

from __future__ import annotations

from dataclasses import dataclass

from gazechair.board.board_commands import Clearance
from gazechair.board.state import BoardState
from gazechair.sensing.clearance.shown import shown
from gazelink import codes

PRESSED_LOOK_S, IDLE_LOOK_S = 0.004, 0.02
"""How often a provider of modes looks at the context: while one of its modes is pressed, else."""
ModeOutput = tuple[int, int] | None
"""A mode's output: linear and turn, permille; None: it has ended."""


@dataclass(frozen=True)
class ModeContext:
    """What modes may know: the press, the board's state, and the clearance."""

    mode: str
    """The mode that is pressed, "" for none."""
    press: int
    """The number of its newest press."""
    state_s: float
    """When the board's state arrived, monotonic; 0: never."""
    armed: bool
    heading_deg: float | None
    acquired_s: float
    """When the clearance was acquired, monotonic; 0: never."""
    clearance: dict[str, float | None]
    """Metres forward and backward, degrees left and right; None: nothing in range, not known."""
    view: dict[str, str]
    """By direction: "seen", "blind" (would be seen), "unseen" (never is)."""
    cap_permille: int = 1000
    """The speed cap: the highest output of each axis."""


def sensed(
    mode: str,
    press: int,
    state: BoardState | None,
    clearance: Clearance | None,
    now_s: float,
    old_s: float,
    cap_permille: int,
) -> ModeContext:
    """What modes may know at `now_s`; a clearance older than `old_s` is none."""
    return ModeContext(
        mode,
        press,
        0.0 if state is None else state.received_s,
        state is not None and state.state == codes.ARMED,
        state.heading_deg if state and state.heading_known else None,
        0.0 if clearance is None else clearance.acquired_s,
        **shown(clearance, now_s, old_s),
        cap_permille=cap_permille,
    )
