"""The clearance as sent to the web pages."""

from __future__ import annotations

from typing import Any

from gazechair.board.board_commands import Clearance
from gazelink import codes
from gazelink.messages import CLEAR_FAR


def shown(clearance: Clearance | None, now_s: float, old_s: float) -> dict[str, Any]:
    """`clearance`: metres forward and backward, degrees left and right, null for nothing in range
    or nothing known; `view`: "seen", "blind" (would be seen) or "unseen" (never is), by direction.

    None, or data older than `old_s`, is blind everywhere.
    """
    if clearance is None or now_s - clearance.acquired_s > old_s:
        blind = dict.fromkeys(codes.DIRECTIONS, "blind")
        return {"clearance": dict.fromkeys(codes.DIRECTIONS), "view": blind}
    ways = (
        _way(clearance.forward_mm, 1000.0, 2),
        _way(clearance.backward_mm, 1000.0, 2),
        _way(clearance.left_q4_deg, 16.0, 0),
        _way(clearance.right_q4_deg, 16.0, 0),
    )
    views = [_view(clearance, direction) for direction in range(len(codes.DIRECTIONS))]
    return {
        "clearance": dict(zip(codes.DIRECTIONS, ways, strict=True)),
        "view": dict(zip(codes.DIRECTIONS, views, strict=True)),
    }


def _way(value: int, unit: float, digits: int) -> float | None:
    return None if value == CLEAR_FAR else round(value / unit, digits)


def _view(clearance: Clearance, direction: int) -> str:
    if clearance.blocked & (1 << direction):
        return "blind"
    return "unseen" if clearance.unseen & (1 << direction) else "seen"
