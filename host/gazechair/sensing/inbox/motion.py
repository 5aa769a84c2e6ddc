"""What the board reports of the chair's motion."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Motion:
    """The board's heading and outputs at a time; None: not known."""

    time_s: float
    heading_deg: float | None
    linear_permille: int | None = None
    turn_permille: int | None = None
