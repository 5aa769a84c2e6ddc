"""Detects scans after a gap that repeat what was seen before it: old data with new times."""

from __future__ import annotations

from collections.abc import Sequence

_GAP_S = 0.15
_LEAST_M_S = 0.12
_BEHIND = 0.6  # share of the expected distance in the gap that is missing
_KEPT = 0.8  # least output as a share of the largest; with less the chair may have stopped
_FEWEST = 3  # states of the board in the gap


def repeats(gap_s: float, speed_m_s: float, moved_m: float, outputs: Sequence[int | None]) -> bool:
    """Whether the first piece after the gap shows no motion though the chair kept driving.

    `speed_m_s`: before the gap; `moved_m`: in it, along the chair; `outputs`: the board's linear
    outputs in it, permille.
    """
    if gap_s < _GAP_S or abs(speed_m_s) < _LEAST_M_S or len(outputs) < _FEWEST:
        return False
    known = [one for one in outputs if one is not None]
    steady = len(known) == len(outputs) and min(known) * max(known) > 0
    if not steady or min(map(abs, known)) < _KEPT * max(map(abs, known)):
        return False
    return moved_m / (speed_m_s * gap_s) < 1.0 - _BEHIND
